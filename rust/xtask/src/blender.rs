//! `cargo xtask blender`: the extension for Blender 4.2 and later and the add-on for Blender 3.4, as zip files that
//! bring the library; and their tests and those of the Python package, in PyPI's bpy and in Debian's Blender.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::files::{copy, copy_files, remove};
use crate::module;
use crate::stage::{Outcome, call, cargo, root, shown, target};
use crate::wheel::{self, environment};

/// What the tests are run with; bpy 5.0 needs Python 3.11.
const PACKAGES: &[&str] = &["bpy==5.0.1", "numpy==1.26.4"];

/// What geodesics are compared with.
const PEERS: &[&str] = &["numpy==1.26.4", "scipy==1.13.1", "potpourri3d==1.4.0"];

/// The tests that run in both hosts, in one process of each.
const TESTS: &[&str] = &[
    "test_folders.py",
    "test_addon.py",
    "test_interface.py",
    "test_assets.py",
    "test_words.py",
    "test_demo.py",
    "test_files.py",
    "test_storage.py",
    "test_cache.py",
    "test_repair.py",
    "test_crowd.py",
    "test_levels.py",
    "test_fluid.py",
    "test_tissue.py",
    "test_decal.py",
    "test_foam.py",
    "test_motion.py",
    "test_scene.py",
    "test_render.py",
    "test_install.py",
];

/// What was made of the add-on.
struct Made {
    /// The wheel's packages, unpacked.
    site: PathBuf,
    /// The zip file for Blender 4.2 and later.
    extension: PathBuf,
    /// The zip file for Blender 3.4.
    addon: PathBuf,
    /// The folder that the second one was made of.
    folder: PathBuf,
}

/// Builds the library and makes the zip files, or runs their tests too.
pub fn run(is_test: bool) -> Outcome {
    build()?;
    if is_test {
        return test();
    }
    zips()?.iter().for_each(|zip| println!("{}", zip.display()));
    Ok(())
}

/// Builds the library and the command.
fn build() -> Outcome {
    call(cargo().args(["build", "--release", "--package", "relievo-capi", "--package", "relievo-cli"]))
}

/// The folder that Blender 3.4 finds the add-on in.
fn scripts(made: &Made) -> &Path {
    made.folder.parent().and_then(Path::parent).unwrap_or(&made.folder)
}

/// Makes the zip files of the library that was built.
pub fn zips() -> Result<[PathBuf; 2], String> {
    let made = make()?;
    Ok([made.extension, made.addon])
}

/// Makes everything of the library that was built and runs `tests/python` and `tests/blender`: those of Python and bpy, those of
/// Blender and those of its window side by side, so that two cores are busy to the end.
pub fn test() -> Outcome {
    let made = make()?;
    let python = python()?;
    let command = target().join("release/relievo");
    let mut alone = Vec::new();
    for name in ["test_abi.py", "test_nouns.py", "test_misuse.py", "test_grid.py", "test_client.py", "test_wheel.py"] {
        let mut test = clean(&python);
        test.env("RELIEVO_OPENVDB", module::path()).env("RELIEVO_COMMAND", &command);
        test.arg(root().join("tests/python").join(name)).env("PYTHONPATH", &made.site);
        alone.push(test);
    }
    let mut geodesics = clean(&environment(&target().join("blender/peers"), PEERS)?);
    geodesics.arg(root().join("tests/python/test_geodesics.py")).env("RELIEVO_COMMAND", &command);
    alone.push(geodesics);
    let scripts = scripts(&made);
    let mut bpy = clean(&python);
    let mut blender = clean(Path::new("blender"));
    blender.args(["--background", "--factory-startup", "--python-exit-code", "1", "--python"]);
    for host in [&mut bpy, &mut blender] {
        host.arg(root().join("tests/blender/suite.py")).arg("--").args(TESTS);
        host.env("BLENDER_USER_SCRIPTS", scripts).env("RELIEVO_COMMAND", &command);
        host.env("RELIEVO_EXTENSION", &made.extension).env("RELIEVO_ADDON", &made.addon);
    }
    alone.push(bpy);
    side_by_side(vec![alone, vec![blender], vec![window(scripts, "window")?]])
}

/// Runs lists of commands side by side, each list one command after the other. All run, also after one that failed.
fn side_by_side(lists: Vec<Vec<Command>>) -> Outcome {
    let run = |mut list: Vec<Command>| list.iter_mut().filter_map(|one| aside(one).err()).collect::<Vec<_>>();
    let failed: Vec<String> = std::thread::scope(|scope| {
        let threads: Vec<_> = lists.into_iter().map(|list| scope.spawn(move || run(list))).collect();
        let ended = threads.into_iter().map(|thread| thread.join());
        ended.flat_map(|failed| failed.unwrap_or_else(|_| vec!["a thread of tests ended early".to_owned()])).collect()
    });
    if failed.is_empty() { Ok(()) } else { Err(failed.join("; ")) }
}

/// Runs a command to its end, then prints what it printed, so that lines of others are not among it. An error has the
/// reports of the tests that failed, which the summary of all stages shows again.
fn aside(command: &mut Command) -> Outcome {
    let printed = command.output().map_err(|error| format!("cannot start `{}`: {error}", shown(command)))?;
    let mut out = std::io::stdout().lock();
    let written = out.write_all(&printed.stdout).and_then(|()| out.flush());
    written.and_then(|()| std::io::stderr().write_all(&printed.stderr)).map_err(|error| error.to_string())?;
    if printed.status.success() {
        return Ok(());
    }
    let messages = String::from_utf8_lossy(&printed.stderr);
    let reports: Vec<_> = messages.lines().skip_while(|line| !line.starts_with("======")).take(100).collect();
    Err(format!("`{}` ended with {}\n{}", shown(command), printed.status, reports.join("\n")))
}

/// Returns the command that runs a file of `tests/blender` in a real window of Debian's Blender, on a display without a screen.
/// Its screenshots go to the folder of `target/blender` that is called as the file.
fn window(scripts: &Path, name: &str) -> Result<Command, String> {
    let pictures = target().join("blender").join(name);
    remove(&pictures)?;
    std::fs::create_dir_all(&pictures).map_err(|error| format!("{}: {error}", pictures.display()))?;
    let mut command = clean(Path::new("xvfb-run"));
    // A window that hangs is ended.
    let blender = "timeout --kill-after 10 600 blender --factory-startup --enable-event-simulate";
    let place = "--window-geometry 0 0 1040 700 --python";
    command.args(["--auto-servernum", "--server-args", "-screen 0 1040x700x24"]);
    command.args(blender.split(' ')).args(place.split(' '));
    command.arg(root().join("tests/blender").join(format!("{name}.py")));
    command.env("BLENDER_USER_SCRIPTS", scripts).env("RELIEVO_SCREENSHOTS", &pictures);
    command.env("LIBGL_ALWAYS_SOFTWARE", "1");
    Ok(command)
}

/// Does the five first tasks of `docs/tasks.md`, and what the manual has pictures of, in a window; puts the pictures into
/// `docs/images`.
pub fn tasks() -> Outcome {
    build()?;
    let made = make()?;
    call(&mut window(scripts(&made), "tasks")?)?;
    for name in ["snow", "frog", "bottle", "wave", "crowd", "repair", "tissue", "result"] {
        let picture = format!("task_{name}.png");
        copy(&target().join("blender/tasks").join(&picture), &root().join("docs/images").join(&picture))?;
    }
    Ok(())
}

/// The Embree that bpy carries.
pub fn embree() -> Result<PathBuf, String> {
    wheel::found(&python()?, "platlib", "bpy/lib/libembree4.so.4")
}

/// A Python with bpy.
pub fn python() -> Result<PathBuf, String> {
    environment(&target().join("blender/bpy"), PACKAGES)
}

/// A command without what would lead it to another library than the one that is tested.
pub fn clean(program: &Path) -> Command {
    let mut command = Command::new(program);
    for name in ["RELIEVO_LIBRARY", "RELIEVO_EMBREE", "PYTHONPATH"] {
        command.env_remove(name);
    }
    command.env("PYTHONDONTWRITEBYTECODE", "1");
    command
}

/// The folders of the add-on's sources.
const FOLDERS: [&str; 6] = ["", "core", "data", "ops", "tools", "ui"];

/// Copies the add-on's sources into a folder.
pub fn sources(to: &Path) -> Outcome {
    let from = root().join("plugins/blender");
    FOLDERS.iter().try_for_each(|folder| copy_files(&from.join(folder), &to.join(folder)))
}

/// Puts the manual with its pictures into a folder of the add-on.
fn manual(folder: &Path) -> Outcome {
    let (docs, to) = (root().join("docs"), folder.join("manual"));
    let page = docs.join("blender.md");
    copy(&page, &to.join("blender.md"))?;
    let text = std::fs::read_to_string(&page).map_err(|error| format!("{}: {error}", page.display()))?;
    let links = text.split("](").filter_map(|rest| rest.split(')').next());
    for picture in links.filter(|path| path.starts_with("images/")) {
        copy(&docs.join(picture), &to.join(picture))?;
    }
    Ok(())
}

fn make() -> Result<Made, String> {
    let wheels = wheel::make()?;
    let base = target().join("blender");
    let python = wheel::tools()?;
    let site = base.join("site");
    let install = ["-m", "pip", "install", "--quiet", "--no-deps", "--no-index", "--disable-pip-version-check"];
    remove(&site)?;
    call(Command::new(&python).args(install).arg("--target").arg(&site).arg(&wheels.library).arg(&wheels.embree))?;
    let version = env!("CARGO_PKG_VERSION");
    let extension = base.join("extension/relievo");
    remove(&extension)?;
    sources(&extension)?;
    manual(&extension)?;
    // Blender has an Embree itself.
    let name = wheels.library.file_name().unwrap_or_default();
    copy(&wheels.library, &extension.join("wheels").join(name))?;
    let folder = base.join("scripts/addons/relievo");
    remove(&folder)?;
    sources(&folder)?;
    manual(&folder)?;
    copy_files(&site.join("librelievo"), &folder.join("librelievo"))?;
    let zip = |folder: &Path, name: String| {
        let path = base.join(name);
        call(Command::new(&python).args(["-m", "zipfile", "--create"]).arg(&path).arg(folder))?;
        Ok::<_, String>(path)
    };
    Ok(Made {
        extension: zip(&extension, format!("relievo-{version}-blender-4.2.zip"))?,
        addon: zip(&folder, format!("relievo-{version}-blender-3.4.zip"))?,
        site,
        folder,
    })
}

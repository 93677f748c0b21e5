//! `cargo xtask blender`: the extension for Blender 4.2 and later and the add-on for Blender 3.4, as zip files that
//! bring the library; and their tests and those of the Python package, in PyPI's bpy and in Debian's Blender.

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

/// The tests that run in both hosts.
const TESTS: &[&str] = &[
    "test_addon.py",
    "test_interface.py",
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
    call(cargo().args(["build", "--release", "--package", "relievo-capi", "--package", "relievo-cli"]))?;
    if is_test {
        return test();
    }
    zips()?.iter().for_each(|zip| println!("{}", zip.display()));
    Ok(())
}

/// Makes the zip files of the library that was built.
pub fn zips() -> Result<[PathBuf; 2], String> {
    let made = make()?;
    Ok([made.extension, made.addon])
}

/// Makes everything of the library that was built and runs `tests/python` and `tests/blender`.
pub fn test() -> Outcome {
    let made = make()?;
    let python = python()?;
    for name in ["test_abi.py", "test_nouns.py", "test_grid.py", "test_client.py", "test_wheel.py"] {
        let mut command = clean(&python);
        command.env("RELIEVO_OPENVDB", module::path()).env("RELIEVO_COMMAND", target().join("release/relievo"));
        call(command.arg(root().join("tests/python").join(name)).env("PYTHONPATH", &made.site))?;
    }
    let mut geodesics = clean(&environment(&target().join("blender/peers"), PEERS)?);
    geodesics.env("RELIEVO_COMMAND", target().join("release/relievo"));
    call(geodesics.arg(root().join("tests/python/test_geodesics.py")))?;
    let scripts = made.folder.parent().and_then(Path::parent).unwrap_or(&made.folder);
    for name in TESTS {
        let file = root().join("tests/blender").join(name);
        let mut bpy = clean(&python);
        let mut blender = clean(Path::new("blender"));
        blender.args(["--background", "--factory-startup", "--python-exit-code", "1", "--python"]);
        for command in [&mut bpy, &mut blender] {
            command
                .arg(&file)
                .env("BLENDER_USER_SCRIPTS", scripts)
                .env("RELIEVO_COMMAND", target().join("release/relievo"));
            command.env("RELIEVO_EXTENSION", &made.extension).env("RELIEVO_ADDON", &made.addon);
        }
        side_by_side(bpy, blender)?;
    }
    window(scripts)
}

/// Runs a test in both hosts at once, since each is busy with its own start for most of the time. What the second one printed
/// follows when both have ended.
fn side_by_side(mut first: Command, mut second: Command) -> Outcome {
    let (alone, printed) = std::thread::scope(|scope| {
        let other = scope.spawn(|| second.output());
        (call(&mut first), other.join())
    });
    let printed = printed.map_err(|_| "the thread of the second host ended early".to_owned())?;
    let printed = printed.map_err(|error| format!("cannot start `{}`: {error}", shown(&second)))?;
    print!("{}", String::from_utf8_lossy(&printed.stdout));
    eprint!("{}", String::from_utf8_lossy(&printed.stderr));
    alone?;
    if printed.status.success() { Ok(()) } else { Err(format!("`{}` ended with {}", shown(&second), printed.status)) }
}

/// Runs `tests/blender/window.py` in a real window of Debian's Blender, on a display without a screen. Its screenshots
/// are in `target/blender/window`.
fn window(scripts: &Path) -> Outcome {
    let pictures = target().join("blender/window");
    remove(&pictures)?;
    std::fs::create_dir_all(&pictures).map_err(|error| format!("{}: {error}", pictures.display()))?;
    let mut command = clean(Path::new("xvfb-run"));
    // A window that hangs is ended.
    let blender = "timeout --kill-after 10 600 blender --factory-startup --enable-event-simulate";
    let place = "--window-geometry 0 0 1200 800 --python";
    command.args(["--auto-servernum", "--server-args", "-screen 0 1200x800x24"]);
    command.args(blender.split(' ')).args(place.split(' ')).arg(root().join("tests/blender/window.py"));
    command.env("BLENDER_USER_SCRIPTS", scripts).env("RELIEVO_SCREENSHOTS", &pictures);
    command.env("LIBGL_ALWAYS_SOFTWARE", "1");
    call(&mut command)
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
    let wheel = wheel::make()?;
    let base = target().join("blender");
    let python = wheel::tools()?;
    let site = base.join("site");
    let install = ["-m", "pip", "install", "--quiet", "--no-deps", "--no-index", "--disable-pip-version-check"];
    remove(&site)?;
    call(Command::new(&python).args(install).arg("--target").arg(&site).arg(&wheel))?;
    let version = env!("CARGO_PKG_VERSION");
    let source = root().join("plugins/blender");

    let extension = base.join("extension/relievo");
    remove(&extension)?;
    copy_files(&source, &extension)?;
    manual(&extension)?;
    copy(&wheel, &extension.join("wheels").join(wheel.file_name().unwrap_or_default()))?;
    let folder = base.join("scripts/addons/relievo");
    remove(&folder)?;
    copy_files(&source, &folder)?;
    manual(&folder)?;
    for part in ["librelievo", "librelievo.libs"] {
        copy_files(&site.join(part), &folder.join(part))?;
    }
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

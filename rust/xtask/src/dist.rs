//! `cargo xtask dist`: what is handed out. An archive and a Debian package of the library, its headers and package files,
//! the command with its manual pages, and the licences of what is linked; the same of the plugin for OpenImageIO and of the
//! module over OpenVDB; the zip files for Blender. CPack makes the first two by the install rules of `CMakeLists.txt` and of the plugin's.

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::files::{copy, only_file, remove, strip};
use crate::stage::{Outcome, call, cargo, output, root, target};
use crate::{blender, licences, module, packages, paths};

/// An archive and a Debian package of the same.
struct Pair {
    archive: PathBuf,
    debian: PathBuf,
}

/// What is handed out, by its files.
struct Packages {
    library: Pair,
    openimageio: Pair,
    openvdb: Pair,
}

/// Builds the library and the command, and makes the packages and the zip files for Blender; uses the packages too for a
/// `test`.
pub fn run(test: bool) -> Outcome {
    call(cargo().args(["build", "--release", "--package", "relievo-capi", "--package", "relievo-cli"]))?;
    module::run()?;
    let made = make()?;
    let zips = blender::zips()?;
    let Packages { library, openimageio, openvdb } = &made;
    let packages = [library, openimageio, openvdb].map(|pair| [&pair.archive, &pair.debian]);
    let folder = target().join("dist/packages");
    remove(&folder)?;
    for file in packages.into_iter().flatten().chain(&zips) {
        let to = folder.join(file.file_name().unwrap_or_default());
        copy(file, &to)?;
        println!("{}", to.display());
    }
    if test { test_made(&made) } else { Ok(()) }
}

/// Makes the packages of what was built.
fn make() -> Result<Packages, String> {
    let folder = target().join("dist");
    let built = folder.join("built");
    for name in ["librelievo.so", "relievo"] {
        strip(&target().join("release").join(name), &built.join(name))?;
    }
    call(Command::new(built.join("relievo")).arg("manual").arg(built.join("man")))?;
    licences::write(&built.join("third-party.txt"))?;
    let define = |name: &str, value: &Path| format!("-D{name}={}", value.display());
    let library = pair(
        &folder,
        "library",
        &root(),
        &[
            define("RELIEVO_LIBRARY_DIR", &built),
            define("RELIEVO_EXTRAS_DIR", &built),
            // It has a package of its own.
            "-DRELIEVO_OPENVDB=OFF".into(),
        ],
    )?;
    // The plugin is built with what the archive has, as anybody else's is.
    unpack(&library.archive, &prefix())?;
    let found = [define("CMAKE_PREFIX_PATH", &prefix()), "-DCMAKE_BUILD_TYPE=Release".into()];
    let openimageio = pair(&folder, "openimageio", &root().join("plugins/oiio"), &found)?;
    let module = built.join(module::FILE);
    strip(&module::path(), &module)?;
    let options = [define("RELIEVO_OPENVDB_MODULE", &module)];
    let openvdb = pair(&folder, "openvdb", &root().join("cpp/openvdb"), &options)?;
    Ok(Packages { library, openimageio, openvdb })
}

/// Has CPack make both packages of a CMake project.
fn pair(folder: &Path, name: &str, source: &Path, options: &[String]) -> Result<Pair, String> {
    Ok(Pair {
        archive: pack(folder, &format!("{name}-archive"), source, "TGZ", options, "-DCMAKE_INSTALL_LIBDIR=lib")?,
        // On Debian libraries are in a folder of the architecture, which CMake finds out for this prefix.
        debian: pack(folder, &format!("{name}-debian"), source, "DEB", options, "-DCMAKE_INSTALL_PREFIX=/usr")?,
    })
}

/// Has CPack make one package.
fn pack(
    folder: &Path,
    name: &str,
    source: &Path,
    generator: &str,
    options: &[String],
    place: &str,
) -> Result<PathBuf, String> {
    let (build, out) = (folder.join(name), folder.join(format!("{name}-package")));
    remove(&out)?;
    let mut configure = Command::new("cmake");
    configure.arg("-S").arg(source).arg("-B").arg(&build).args(["-G", "Ninja", place]).args(options);
    call(&mut configure)?;
    call(Command::new("cmake").arg("--build").arg(&build))?;
    call(Command::new("cpack").current_dir(&build).args(["-G", generator, "-B"]).arg(&out))?;
    // CPack leaves its working folder beside the package.
    remove(&out.join("_CPack_Packages"))?;
    only_file(&out)
}

/// Where the archives are unpacked to.
fn prefix() -> PathBuf {
    target().join("dist/prefix")
}

/// Unpacks an archive to a folder that is made anew.
fn unpack(archive: &Path, folder: &Path) -> Outcome {
    remove(folder)?;
    unpack_beside(archive, folder)
}

/// Unpacks an archive to a folder that may be there.
fn unpack_beside(archive: &Path, folder: &Path) -> Outcome {
    std::fs::create_dir_all(folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    call(Command::new("tar").arg("-xzf").arg(archive).arg("--strip-components=1").arg("-C").arg(folder))
}

/// Makes the packages and uses each.
pub fn test() -> Outcome {
    test_made(&make()?)
}

/// Uses each package where nothing else of ours is: the archives in a prefix of their own, the Debian packages in a bare
/// Debian 12.
fn test_made(made: &Packages) -> Outcome {
    test_archives(made)?;
    test_debian(made)
}

fn test_archives(made: &Packages) -> Outcome {
    let folder = prefix();
    unpack(&made.library.archive, &folder)?;
    for file in [
        "share/man/man1/relievo-scene-run.1",
        "share/doc/relievo/third-party.txt",
        "lib/cmake/Relievo/RelievoConfig.cmake",
    ] {
        if !folder.join(file).is_file() {
            return Err(format!("the archive lacks {file}"));
        }
    }
    let consumer = root().join("tests/hosts/pkg-config-consumer/run.sh");
    call(Command::new("sh").arg(consumer).arg(&folder).arg(target().join("dist/consumer")).arg("cc"))?;
    let out = target().join("dist/run");
    remove(&out)?;
    let mut run = Command::new(folder.join("bin/relievo"));
    call(run.args(["scene", "run"]).arg(root().join(SCENE)).args(["--frames", "0..1", "--out"]).arg(out))?;
    // The command finds the module of an unpacked archive, and says what to install without it.
    let out = target().join("dist/run/box.vdb");
    let convert = || {
        let mut convert = Command::new(folder.join("bin/relievo"));
        // Cargo names the folder with the module that was built in the second.
        convert.env_remove("RELIEVO_OPENVDB").env_remove("LD_LIBRARY_PATH");
        convert.args(["grid", "convert"]).arg(root().join(CAGE));
        convert.arg("-o").arg(&out).args(["--voxel", "0.05"]);
        convert
    };
    let refused = convert().output().map_err(|error| error.to_string())?;
    if refused.status.success() || !String::from_utf8_lossy(&refused.stderr).contains("relievo-openvdb") {
        return Err("without the module the command does not name its package".into());
    }
    unpack_beside(&made.openvdb.archive, &folder)?;
    call(&mut convert())?;
    unpack_beside(&made.openimageio.archive, &folder)?;
    let mut info = Command::new("oiiotool");
    info.env("OIIO_LIBRARY_PATH", folder.join("lib/relievo")).args(["--info", "-v"]).arg(root().join(DOCUMENT));
    let text = output(&mut info)?;
    // All three archives are there now.
    ["bin", "lib"].into_iter().try_for_each(|part| paths::check(&folder.join(part)))?;
    if text.contains(SHOWN) { Ok(()) } else { Err(format!("oiiotool does not print {SHOWN}: {text}")) }
}

/// What the packages are tried with: it makes pictures, so that Embree is found too.
const SCENE: &str = "examples/scenes/press.toml";

/// What the module is tried with.
const CAGE: &str = "tests/hosts/comparison/cage.obj";

/// What the plugin is tried with, and what is printed of it.
const DOCUMENT: &str = "tests/golden/document-3.relievo";
const SHOWN: &str = "relievo:faces:";

/// Where the package has the service, and how the server is tried: `timeout` returns 124 where it had to stop it.
const UNIT: &str = "lib/systemd/system/relievo.service";
const SERVE: &str = "timeout 3 relievo server run --listen unix:/tmp/socket --cache /tmp/cache";

/// Installs the packages with what they depend on into a bare system, runs a scene there and looks into a document.
fn test_debian(made: &Packages) -> Outcome {
    if !packages::is_root() {
        println!("skipped: only root can make a bare Debian to install the packages in");
        return Ok(());
    }
    let hook = |line: &str| OsString::from(format!("--customize-hook={line}"));
    let into = |file: &Path| hook(&format!("copy-in '{}' /tmp", file.display()));
    let name = |file: &Path| format!("/tmp/{}", file.file_name().unwrap_or_default().to_string_lossy());
    let (library, plugin, grids) = (&made.library.debian, &made.openimageio.debian, &made.openvdb.debian);
    let mut bare = Command::new("mmdebstrap");
    bare.args(["--quiet", "--variant=apt"]).arg(into(library)).arg(into(plugin));
    bare.arg(into(grids)).arg(into(&root().join(CAGE)));
    bare.arg(into(&root().join(SCENE))).arg(into(&root().join(DOCUMENT)));
    let install =
        |file: &Path, more: &str| hook(&format!("chroot \"$1\" apt-get install --yes {more} --quiet=2 {}", name(file)));
    bare.arg(install(library, "--install-recommends"));
    bare.arg(hook(
        "chroot \"$1\" sh -c 'cd /tmp && relievo scene run press.toml --frames 0..1 --out out && ls out/*.png'",
    ));
    // The service is there and off, and what it starts serves until it is asked to stop.
    bare.arg(hook(&format!("test -f \"$1\"/usr/{UNIT} && ! ls \"$1\"/etc/systemd/system/*/relievo.service")));
    bare.arg(hook(&format!("chroot \"$1\" sh -c '{SERVE}; test $? = 124'")));
    bare.arg(install(grids, "--no-install-recommends"));
    let convert = format!("relievo grid convert {} -o box.vdb --voxel 0.05", name(Path::new(CAGE)));
    bare.arg(hook(&format!("chroot \"$1\" sh -c 'cd /tmp && {convert} && relievo grid info box.vdb'")));
    // Not all that the tools recommend.
    bare.arg(install(plugin, "--no-install-recommends openimageio-tools"));
    let look = format!("OIIO_LIBRARY_PATH=$(echo /usr/lib/*/relievo) oiiotool --info -v {}", name(Path::new(DOCUMENT)));
    bare.arg(hook(&format!("chroot \"$1\" sh -c '{look} | grep {SHOWN}'")));
    call(bare.args(["bookworm", "/dev/null"]))
}

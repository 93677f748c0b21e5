//! Commands stand under their noun, and their earlier names do the same.

use std::path::Path;

use super::{CUBE, relievo, text};

/// Earlier names, and the noun and the verb of each now.
const SPELLINGS: [(&str, [&str; 2]); 17] = [
    ("run", ["scene", "run"]),
    ("new", ["scene", "new"]),
    ("check", ["scene", "check"]),
    ("schema", ["scene", "schema"]),
    ("export", ["scene", "export"]),
    ("simplify", ["mesh", "simplify"]),
    ("tessellate", ["mesh", "tessellate"]),
    ("stroke", ["doc", "stroke"]),
    ("plot", ["fluid", "plot"]),
    ("serve", ["server", "run"]),
    ("submit", ["server", "submit"]),
    ("status", ["server", "status"]),
    ("watch", ["server", "watch"]),
    ("fetch", ["server", "fetch"]),
    ("steer", ["server", "steer"]),
    ("control", ["server", "control"]),
    ("cache", ["server", "cache"]),
];

/// Runs both spellings with the same arguments and compares the exit code and all that is printed. Returns the exit code
/// and standard output.
fn same(folder: &Path, earlier: &str, now: [&str; 2], arguments: &[&str]) -> (Option<i32>, String) {
    let before = relievo(folder, &[&[earlier], arguments].concat());
    let after = relievo(folder, &[&now[..], arguments].concat());
    assert_eq!(before, after, "{earlier} {arguments:?}");
    (after.status.code(), text(&after.stdout))
}

/// Returns whether this build has the commands of a noun.
fn is_built(noun: &str) -> bool {
    noun != "server" || cfg!(feature = "server")
}

#[test]
fn earlier_names_have_the_help_and_the_errors_of_the_new_ones() {
    let folder = tempfile::tempdir().unwrap();
    let list = text(&relievo(folder.path(), &["--help"]).stdout);
    for (earlier, now) in SPELLINGS.into_iter().filter(|(_, [noun, _])| is_built(noun)) {
        let usage = format!("Usage: relievo {} {}", now[0], now[1]);
        let (code, help) = same(folder.path(), earlier, now, &["--help"]);
        assert!(code == Some(0) && help.contains(&usage), "{earlier}: {help}");
        let asked = relievo(folder.path(), &["help", earlier]);
        assert_eq!(asked, relievo(folder.path(), &["help", now[0], now[1]]), "help {earlier}");
        assert_eq!(same(folder.path(), earlier, now, &["--no-such-option"]).0, Some(2));
        assert!(!list.contains(&format!("\n  {earlier} ")), "{earlier} is in\n{list}");
    }
}

#[test]
fn earlier_names_do_what_the_new_ones_do() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    std::fs::write(at.join("cube.obj"), CUBE).unwrap();
    let scene = "version = 1\n[meshes.a]\nfile = \"cube.obj\"\n[surfaces.a]\nmesh = \"a\"\n[objects.a]\nsurface = \"a\"\n\
                 [output]\nframes = 1\npictures = []\nmesh = \"last\"\n";
    std::fs::write(at.join("scene.toml"), scene).unwrap();
    std::fs::write(
        at.join("list.toml"),
        "version = 1\n[[strokes]]\nradius = 0.3\nsculpt = \"draw\"\nheight = 0.1\n\
                 [[strokes.points]]\nposition = [0, 0, 1]\n",
    )
    .unwrap();
    let patches = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/fuzz/seeds/patches/seed.bpt");
    // Both print the same, and write the same files.
    for (earlier, now, arguments, written) in [
        ("new", ["scene", "new"], &["cube.obj"][..], None),
        ("check", ["scene", "check"], &["scene.toml"], None),
        ("schema", ["scene", "schema"], &["--json"], None),
        ("export", ["scene", "export"], &["pov", "scene.toml", "--out", "pov"], Some("pov/scene-000000.pov")),
        ("simplify", ["mesh", "simplify"], &["cube.obj", "-o", "less.obj", "--faces", "8"], Some("less.obj")),
        ("tessellate", ["mesh", "tessellate"], &[patches, "-o", "pot.ply", "--level", "1"], Some("pot.ply")),
        ("stroke", ["doc", "stroke"], &["cube.obj", "list.toml", "-o", "dent.obj"], Some("dent.obj")),
    ] {
        let bytes = |spelling: &[&str]| {
            let done = relievo(at, &[spelling, arguments].concat());
            assert!(done.status.success(), "{spelling:?}: {done:?}");
            written.map(|file| {
                let bytes = std::fs::read(at.join(file)).unwrap();
                std::fs::remove_file(at.join(file)).unwrap();
                bytes
            })
        };
        assert!(bytes(&[earlier]) == bytes(&now), "{earlier}");
        assert_eq!(same(at, earlier, now, arguments).0, Some(0));
    }
    // A run prints what its stages cost, which differs each time.
    for (spelling, out) in [(&["run"][..], "before"), (&["scene", "run"], "after")] {
        let done = relievo(at, &[spelling, &["scene.toml", "--out", out]].concat());
        assert!(done.status.success(), "{done:?}");
    }
    let mesh = |out: &str| std::fs::read(at.join(out).join("mesh-000000.glb")).unwrap();
    assert!(mesh("before") == mesh("after"));
    assert_eq!(same(at, "plot", ["fluid", "plot"], &["none.csv", "-o", "a.svg"]).0, Some(1));
    if !is_built("server") {
        return;
    }
    // Without the file of a token all of these fail alike, before they look for a server.
    let failing: [(_, _, &[&str]); 7] = [
        ("serve", ["server", "run"], &["--listen", "unix:none/socket", "--cache", "kept"]),
        ("submit", ["server", "submit"], &["none.toml"]),
        ("status", ["server", "status"], &[]),
        ("watch", ["server", "watch"], &["dam"]),
        ("fetch", ["server", "fetch"], &["dam", "-o", "frames"]),
        ("steer", ["server", "steer"], &["dam", "--after", "1", "--set", "fluid.viscosity = 0.1"]),
        ("control", ["server", "control"], &["dam", "pause"]),
    ];
    for (earlier, now, arguments) in failing {
        assert_eq!(same(at, earlier, now, &[arguments, &["--token-file", "none"]].concat()).0, Some(1), "{earlier}");
    }
    assert_eq!(same(at, "cache", ["server", "cache"], &["ls", "--cache", "none"]).0, Some(1));
}

#[test]
fn texts_name_commands_by_their_noun() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let mut places: Vec<_> = ["README.md", "CHANGELOG.md", "docs", "examples", "include", "packaging", "plugins"]
        .into_iter()
        .chain(["rust/cli/src", "rust/meshio/src", "rust/scene/src", "rust/server/src", "rust/view/src"])
        .map(|place| root.join(place))
        .collect();
    let (mut files, mut found) = (0, String::new());
    while let Some(place) = places.pop() {
        if place.is_dir() {
            places.extend(std::fs::read_dir(&place).unwrap().map(|entry| entry.unwrap().path()));
            continue;
        }
        // Pictures are no text.
        let Ok(contents) = std::fs::read_to_string(&place) else { continue };
        if place.ends_with("rust/cli/src/spelling.rs") {
            continue;
        }
        files += 1;
        for (number, line) in contents.lines().enumerate() {
            let names = line.match_indices("relievo ").map(|(start, name)| &line[start + name.len()..]);
            let mut names = names.map(|rest| rest.split(|letter: char| !letter.is_ascii_alphabetic()).next());
            if names.any(|name| SPELLINGS.iter().any(|(earlier, _)| name == Some(*earlier))) {
                found += &format!("{}:{}: {line}\n", place.display(), number + 1);
            }
        }
    }
    assert!(files > 300, "only {files} files were read");
    assert!(found.is_empty(), "commands by their earlier names:\n{found}");
}

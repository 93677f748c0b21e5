//! Objects of scenes whose edits fade: also across a run that goes on from its cache, and until no memory is left.

use crate::support::run_in;

const SCENE: &str = concat!(
    ground_and_tool!(),
    r##"KIND[details]
segments = 16
tile_size = 16
paint_size = 16
[objects.ground]
surface = "ground"
decay = { delay = 0.1, duration = 0.3 }
"##,
    pressing_tool!(),
    r##"[[strokes]]
object = "ground"
paint = "mix"
time = 0.1
radius = 0.1
points = [{ position = [-0.3, -0.3, 0] }, { position = [0.3, -0.3, 0] }]
[output]
frames = 16
picture_frames = "none"
mesh = "none"
documents = "every"
"##,
);

/// What surfaces of triangles say, whose vertices always have values.
const TRIANGLES: &str = "kind = \"triangles\"\nlongest_edge = 0.3\n";

/// The same edits on layers that fade, over an object that does not.
fn layered() -> String {
    let decay = "decay = { delay = 0.1, duration = 0.3 }\n";
    let layer = |name: &str, kind: &str| {
        format!("[[objects.ground.layers]]\nname = \"{name}\"\nkind = \"{kind}\"\ntile_size = 16\n{decay}")
    };
    let layers = layer("frost", "colour") + &layer("unused", "displacement");
    let text = SCENE.replace(decay, &layers).replace("paint = \"mix\"", "paint = \"mix\"\nlayer = \"frost\"");
    // Imprints go to the lowest layer, which stays.
    text.replace("[colliders.tool]\n", "")
}

#[test]
fn edits_fade_until_nothing_is_left_also_from_the_cache() {
    for (text, kind) in [(SCENE, ""), (&*layered(), ""), (SCENE, TRIANGLES), (&*layered(), TRIANGLES)] {
        let text = text.replace("KIND", kind);
        let folder = tempfile::tempdir().unwrap();
        let run = |name: &str, frames| run_in(folder.path(), name, &text, frames, 1);
        let whole = run("whole", None);
        assert_eq!(whole.tiles[0], 0);
        assert!(whole.tile_bytes[0] == 0 || kind == TRIANGLES);
        let first = run("parts", Some((0, 5)));
        assert!(first.tile_bytes[0] > 0 && first.tiles[0] > 0, "{first:?}");
        let second = run("parts", Some((0, 9)));
        assert_eq!((second.opened, second.baked), (6, 4));
        let rest = run("parts", None);
        assert_eq!((rest.opened, rest.baked), (10, 6));
        let path =
            |name: &str, frame: u32| folder.path().join(name).join(format!("document-{frame:06}-ground.relievo"));
        for frame in 0..16 {
            let read = |name: &str| std::fs::read(path(name, frame)).unwrap();
            assert_eq!(read("whole"), read("parts"), "frame {frame}");
        }
        if kind == TRIANGLES {
            let run = |frames| run_in(folder.path(), "threads", &text, frames, 3);
            run(Some((0, 15)));
            let path = |name: &str| folder.path().join(name).join("document-000012-ground.relievo");
            assert_eq!(std::fs::read(path("threads")).unwrap(), std::fs::read(path("whole")).unwrap());
        }
        // A scene that starts from a document goes on from its time, and fades what is left of it.
        std::fs::copy(path("whole", 6), folder.path().join("start.relievo")).unwrap();
        let rest = &text[..text.find("[[strokes]]").unwrap()];
        let rest = rest.replace("surface = \"ground\"\n", "surface = \"ground\"\ndocument = \"start.relievo\"\n");
        let rest = rest.replace("[colliders.tool]\n", "");
        let later = format!("{rest}[output]\nframes = 10\npicture_frames = \"none\"\nmesh = \"none\"\n");
        let begun = run_in(folder.path(), "begun", &later, Some((0, 0)), 1);
        assert!(begun.tiles[0] > 0, "{begun:?}");
        assert_eq!(run_in(folder.path(), "begun", &later, None, 1).tiles[0], 0);
    }
}

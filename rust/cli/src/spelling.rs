//! Earlier spellings of commands, from before each stood under its noun. Scripts still use them.

use std::ffi::OsString;

/// Earlier names, and the noun and the verb of each now.
const MOVED: [(&str, [&str; 2]); 17] = [
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

/// Returns the arguments of a command line, the program's name first, with an earlier spelling replaced, also after
/// `help`.
pub fn current(arguments: impl IntoIterator<Item = OsString>) -> Vec<OsString> {
    let mut arguments: Vec<OsString> = arguments.into_iter().collect();
    let place = if arguments.get(1).is_some_and(|first| first == "help") { 2 } else { 1 };
    let moved = arguments.get(place).and_then(|name| MOVED.iter().find(|(earlier, _)| name == earlier));
    if let Some((_, now)) = moved {
        arguments.splice(place..=place, now.map(OsString::from));
    }
    arguments
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory;

    use super::*;

    #[test]
    fn earlier_names_are_replaced_in_the_place_of_a_command_alone() {
        let current = |line: &str| current(line.split(' ').map(OsString::from)).join(" ".as_ref());
        assert_eq!(current("relievo run run.toml"), "relievo scene run run.toml");
        assert_eq!(current("relievo help serve"), "relievo help server run");
        for same in ["relievo", "relievo mesh check run", "relievo info run", "relievo --version run"] {
            assert_eq!(current(same), same);
        }
    }

    #[test]
    fn earlier_names_are_of_no_other_command() {
        let command = crate::Arguments::command();
        for (earlier, [noun, verb]) in MOVED {
            assert!(command.find_subcommand(earlier).is_none(), "{earlier}");
            // A build without a feature has no commands of it.
            let noun = command.find_subcommand(noun);
            assert!(noun.is_none_or(|noun| noun.find_subcommand(verb).is_some()), "{earlier}");
        }
    }
}

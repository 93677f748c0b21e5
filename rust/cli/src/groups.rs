//! The commands by what they work on, for `relievo --help`.

use clap::Command;

/// Headings, and the commands below each.
const GROUPS: [(&str, &[&str]); 7] = [
    ("Scenes", &["scene"]),
    ("Surfaces and their details", &["view", "doc"]),
    ("Meshes", &["mesh", "progressive", "decal", "crowd"]),
    ("Fluids, soft tissue and grids", &["fluid", "foam", "tissue", "grid"]),
    ("Simulation servers and farms", &["server", "farm"]),
    ("Pictures", &["draw", "compare", "shader"]),
    ("Files and devices", &["info", "devices"]),
];

/// Lists the subcommands of `command` in groups in its help.
pub fn grouped(command: Command) -> Command {
    let mut list = String::new();
    for (heading, names) in GROUPS {
        list += &format!("{heading}:\n");
        for name in names {
            // A build without a feature has no command of it.
            let Some(found) = command.find_subcommand(name) else { continue };
            list += &format!("  {name:<12} {}\n", found.get_about().map(ToString::to_string).unwrap_or_default());
        }
        list.push('\n');
    }
    command.help_template(format!("{{about}}\n\n{{usage-heading}} {{usage}}\n\n{list}Options:\n{{options}}"))
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use clap::CommandFactory;

    use super::*;

    #[test]
    fn every_command_is_in_one_group_and_in_the_help() {
        let command = crate::Arguments::command();
        let there: BTreeSet<_> =
            command.get_subcommands().filter(|it| !it.is_hide_set()).map(Command::get_name).collect();
        let listed: Vec<_> = GROUPS.iter().flat_map(|(_, names)| *names).copied().collect();
        assert_eq!(listed.len(), there.len());
        assert_eq!(listed.into_iter().collect::<BTreeSet<_>>(), there);
        let help = grouped(crate::Arguments::command()).render_help().to_string();
        for name in there {
            assert!(help.contains(&format!("\n  {name} ")), "{name} is not in\n{help}");
        }
        assert!(help.contains("Usage: relievo") && help.contains("--version"), "{help}");
    }
}

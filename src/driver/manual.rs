//! `gmlvm completions` and `gmlvm man`: the command line as shells and `man` want it.

use std::path::Path;

use clap::{Command, CommandFactory};

use crate::args::{Args, CompletionsArgs, ManArgs};
use crate::console;
use crate::failure::Failure;
use crate::output::Target;

pub(super) fn completions(args: &CompletionsArgs) -> Result<u8, Failure> {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut Args::command(), "gmlvm", &mut script);
    console::data(|out| out.write_all(&script))?;
    Ok(0)
}

pub(super) fn man(args: &ManArgs) -> Result<u8, Failure> {
    let mut command = Args::command().disable_help_subcommand(true);
    // So that the options that all commands share are on each page.
    command.build();
    write(&command, "gmlvm", &args.dir)?;
    for sub in command.get_subcommands() {
        let name = format!("gmlvm-{}", sub.get_name());
        write(sub, &name, &args.dir)?;
    }
    Ok(0)
}

fn write(command: &Command, name: &str, directory: &Path) -> Result<(), Failure> {
    let page = clap_mangen::Man::new(command.clone()).title(name.to_uppercase());
    let mut text = Vec::new();
    page.render(&mut text).map_err(|error| {
        Failure::Output(format!("could not make the page of {name}: {}", console::reason(&error)))
    })?;
    let target = Target::path(directory.join(format!("{name}.1")));
    target.write_plain(&mut |out| out.write_all(&text))
}

//! Diagnostics for the user: with the source text, on one line each, or as JSON.

use compiler::diagnostic::{Class, Diagnostic};
use compiler::source::SourceMap;

use crate::args::{ColorChoice, Common, MessageFormat};
use crate::clean::clean_lines;
use crate::console;
use crate::failure::Failure;

pub(crate) mod hint;

mod excerpt;
mod human;
mod machine;

pub(crate) use machine::plain_json;

/// Tells the user what is wrong, in the manner that the command line asks for.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Reporter {
    format: MessageFormat,
    /// Whether what is written for the eye may be coloured.
    pub(crate) color: bool,
    /// The user wants to hear of errors only.
    pub(crate) quiet: bool,
    /// The user wants to hear of phases and decisions.
    pub(crate) verbose: bool,
}

impl Reporter {
    /// A reporter as the options say.
    pub(crate) fn new(options: &Common) -> Self {
        let color = match options.color {
            ColorChoice::Always => true,
            ColorChoice::Never => false,
            ColorChoice::Auto => console::wants_color(),
        };
        let Common { quiet, verbose, message_format, .. } = *options;
        Reporter { format: message_format, color, quiet, verbose }
    }

    /// A reporter of errors only, each as a line of JSON.
    pub(crate) fn for_programs() -> Self {
        Reporter { format: MessageFormat::Json, color: false, quiet: true, verbose: false }
    }

    /// The same, but for errors only.
    pub(crate) fn of_errors(self) -> Self {
        Reporter { quiet: true, verbose: false, ..self }
    }

    /// Shows an error that has no place in a program.
    pub(crate) fn message(&self, message: &str) {
        console::say(&match self.format {
            MessageFormat::Human => human::plain(&clean_lines(message), self.color),
            MessageFormat::Short => format!("error: {}\n", clean_lines(message)),
            MessageFormat::Json => machine::plain_json(message),
        });
    }

    /// Shows diagnostics; `replacement` is what may be meant by the last one's primary place.
    ///
    /// Returns the failure to end with: of the first diagnostic's class.
    pub(crate) fn diagnostics(
        &self,
        diagnostics: &[Diagnostic],
        sources: &SourceMap,
        replacement: Option<&str>,
    ) -> Failure {
        for (idx, diagnostic) in diagnostics.iter().enumerate() {
            let replacement = replacement.filter(|_| idx + 1 == diagnostics.len());
            let text = match self.format {
                MessageFormat::Human => {
                    let gap = if idx > 0 { "\n" } else { "" };
                    let text = human::render(diagnostic, sources, replacement, self.color);
                    format!("{gap}{text}\n")
                }
                MessageFormat::Short => machine::short(diagnostic, sources),
                MessageFormat::Json => machine::json(diagnostic, sources, replacement),
            };
            console::say(&text);
        }
        let class = diagnostics.first().map_or(Class::Program, |first| first.code.class());
        Failure::Shown(class)
    }

    /// Says something that is not an error, unless the user wants quiet.
    pub(crate) fn note(&self, line: &str) {
        if !self.quiet {
            console::say(&format!("{}\n", clean_lines(line)));
        }
    }

    /// Says something that only those who asked for more want to hear.
    pub(crate) fn detail(&self, line: &str) {
        if self.verbose {
            console::say(&format!("{}\n", clean_lines(line)));
        }
    }
}

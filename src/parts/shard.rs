//! Shards: which of several runs renders which bands.

use std::fmt;

use crate::failure::Failure;

/// The `index`th of `count` shares, from 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Shard {
    pub(crate) index: u32,
    pub(crate) count: u32,
}

/// What the command line says of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ShardChoice {
    /// This one.
    Given(Shard),
    /// That of the job which the environment tells of.
    Auto,
}

impl Shard {
    /// Whether the `band`th band of the `image`th image is in this share. Neighbours go to different
    /// ones, since they take about as long; the bands of images begin with different ones, since small
    /// images have few.
    pub(crate) fn has(self, image: u64, band: usize) -> bool {
        (image + band as u64) % u64::from(self.count) == u64::from(self.index)
    }
}

impl fmt::Display for Shard {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.index + 1, self.count)
    }
}

impl ShardChoice {
    /// The shard.
    ///
    /// # Errors
    /// When the environment tells of no job, or of one that makes no sense.
    pub(crate) fn resolve(self) -> Result<Shard, Failure> {
        match self {
            ShardChoice::Given(shard) => Ok(shard),
            ShardChoice::Auto => auto(&|name| std::env::var(name).ok()).map_err(Failure::Usage),
        }
    }
}

/// Reads `K/N` or `auto`.
pub(crate) fn choice(text: &str) -> Result<ShardChoice, String> {
    if text == "auto" {
        return Ok(ShardChoice::Auto);
    }
    let numbers =
        text.split_once('/').and_then(|(k, n)| k.parse::<u32>().ok().zip(n.parse::<u32>().ok()));
    match numbers {
        Some((number, count)) if 1 <= number && number <= count => {
            Ok(ShardChoice::Given(Shard { index: number - 1, count }))
        }
        _ => Err("write K/N with K from 1 to N, as in 2/8, or auto".to_owned()),
    }
}

/// How a kind of job numbers its tasks.
struct Numbering {
    /// The variable that has the number.
    number: &'static str,
    first: First,
    count: Count,
}

/// The number of the first task.
enum First {
    Fixed(u64),
    /// It and the distance of one number to the next are in these variables.
    Variables(&'static str, &'static str),
}

/// The number of tasks.
enum Count {
    Variable(&'static str),
    /// In this variable, or following from the last number, in that one.
    VariableOrLast(&'static str, &'static str),
}

/// Where N is to be found if the job does not tell it.
const SHARDS: &str = "GMLVM_SHARDS";

/// The jobs that are known, what is more particular first: a task of a Slurm array is a step too, and
/// so may be what GNU parallel or `mpirun` run in one.
const NUMBERINGS: [Numbering; 5] = [
    Numbering { number: "PARALLEL_SEQ", first: First::Fixed(1), count: Count::Variable(SHARDS) },
    Numbering {
        number: "OMPI_COMM_WORLD_RANK",
        first: First::Fixed(0),
        count: Count::Variable("OMPI_COMM_WORLD_SIZE"),
    },
    Numbering {
        number: "SLURM_ARRAY_TASK_ID",
        first: First::Variables("SLURM_ARRAY_TASK_MIN", "SLURM_ARRAY_TASK_STEP"),
        count: Count::VariableOrLast("SLURM_ARRAY_TASK_COUNT", "SLURM_ARRAY_TASK_MAX"),
    },
    Numbering {
        number: "JOB_COMPLETION_INDEX",
        first: First::Fixed(0),
        count: Count::Variable(SHARDS),
    },
    Numbering {
        number: "SLURM_PROCID",
        first: First::Fixed(0),
        count: Count::Variable("SLURM_NTASKS"),
    },
];

/// The shard of the job that the environment tells of.
fn auto(variable: &dyn Fn(&str) -> Option<String>) -> Result<Shard, String> {
    let found = NUMBERINGS.iter().find(|numbering| variable(numbering.number).is_some());
    let Some(Numbering { number, first, count }) = found else {
        let known: Vec<_> = NUMBERINGS.iter().map(|numbering| numbering.number).collect();
        return Err(format!(
            "`--shard auto`: the environment tells of no job; it has none of {}",
            known.join(", ")
        ));
    };
    let read = |name: &str| match variable(name) {
        None => Ok(None),
        Some(text) => text
            .trim()
            .parse::<u64>()
            .map(Some)
            .map_err(|_| format!("`--shard auto`: {name} is `{text}`, which is no number")),
    };
    let missing = |name: &str| format!("`--shard auto`: there is {number}, but not {name}");
    let task = read(number)?.unwrap_or_default();
    let (first, step) = match first {
        First::Fixed(first) => (*first, 1),
        First::Variables(first, step) => {
            (read(first)?.ok_or_else(|| missing(first))?, read(step)?.unwrap_or(1).max(1))
        }
    };
    let n_tasks = match count {
        Count::Variable(name) => read(name)?.ok_or_else(|| missing(name))?,
        Count::VariableOrLast(name, last) => match read(name)? {
            Some(count) => count,
            None => {
                let last = read(last)?.ok_or_else(|| missing(name))?;
                last.saturating_sub(first) / step + 1
            }
        },
    };
    let index = task.checked_sub(first).map(|distance| distance / step);
    let shard = index.filter(|index| *index < n_tasks).and_then(|index| {
        Some(Shard { index: index.try_into().ok()?, count: n_tasks.try_into().ok()? })
    });
    shard.ok_or_else(|| {
        format!(
            "`--shard auto`: {number} is {task}, which is none of {n_tasks} tasks from {first} on"
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shards_are_written_from_one_on() {
        assert_eq!(choice("1/1"), Ok(ShardChoice::Given(Shard { index: 0, count: 1 })));
        assert_eq!(choice("8/8"), Ok(ShardChoice::Given(Shard { index: 7, count: 8 })));
        assert_eq!(choice("auto"), Ok(ShardChoice::Auto));
        for bad in ["", "/", "0/8", "9/8", "1/0", "0/0", "-1/8", "1/8/2", "1", "1/99999999999"] {
            assert!(choice(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn every_band_is_in_one_shard() {
        for count in [1, 2, 3, 8, 100] {
            for (image, band) in (1..5).flat_map(|image| (0..70).map(move |band| (image, band))) {
                let having = (0..count).filter(|&index| Shard { index, count }.has(image, band));
                assert_eq!(having.count(), 1);
            }
        }
    }

    #[test]
    fn jobs_tell_of_shards() {
        let of = |variables: &str| {
            let find = |name: &str| {
                let words = variables.split_whitespace().filter_map(|word| word.split_once('='));
                words.rev().find(|(key, _)| *key == name).map(|(_, value)| value.to_owned())
            };
            auto(&find).map(|shard| shard.to_string())
        };
        let array = "SLURM_ARRAY_TASK_ID=7 SLURM_ARRAY_TASK_MIN=3 SLURM_PROCID=0 SLURM_NTASKS=1";
        let is = |variables: &str, shard: &str| {
            assert_eq!(of(variables).as_deref(), Ok(shard), "{variables}");
        };
        is(&format!("{array} SLURM_ARRAY_TASK_COUNT=8"), "5/8");
        is(&format!("{array} SLURM_ARRAY_TASK_MAX=9"), "5/7");
        is(&format!("{array} SLURM_ARRAY_TASK_MAX=11 SLURM_ARRAY_TASK_STEP=2"), "3/5");
        is(&format!("{array} SLURM_ARRAY_TASK_COUNT=8 PARALLEL_SEQ=2 GMLVM_SHARDS=4"), "2/4");
        is("SLURM_PROCID=0 SLURM_NTASKS=3", "1/3");
        is("PARALLEL_SEQ=3 GMLVM_SHARDS=3", "3/3");
        is("JOB_COMPLETION_INDEX=0 GMLVM_SHARDS=3", "1/3");
        is("OMPI_COMM_WORLD_RANK=3 OMPI_COMM_WORLD_SIZE=4", "4/4");
        for (variables, why) in [
            ("HOME=/root", "tells of no job"),
            ("PARALLEL_SEQ=3", "but not GMLVM_SHARDS"),
            ("PARALLEL_SEQ=4 GMLVM_SHARDS=3", "none of 3 tasks from 1 on"),
            ("PARALLEL_SEQ=0 GMLVM_SHARDS=3", "none of 3 tasks"),
            ("PARALLEL_SEQ=1 GMLVM_SHARDS=0", "none of 0 tasks"),
            ("PARALLEL_SEQ=1 GMLVM_SHARDS=99999999999", "none of 99999999999 tasks"),
            ("JOB_COMPLETION_INDEX=x GMLVM_SHARDS=3", "`x`, which is no number"),
            ("SLURM_ARRAY_TASK_ID=7", "but not SLURM_ARRAY_TASK_MIN"),
            (array, "but not SLURM_ARRAY_TASK_COUNT"),
            (
                &format!("{array} SLURM_ARRAY_TASK_ID=2 SLURM_ARRAY_TASK_COUNT=8"),
                "none of 8 tasks from 3",
            ),
        ] {
            let error = of(variables).expect_err(variables);
            assert!(error.contains(why), "{variables}: {error}");
        }
    }
}

// SPDX-License-Identifier: MIT OR Apache-2.0
//! Which items of a recipe one process bakes.

use std::ops::RangeInclusive;

use crate::error::{Error, Result};

/// A part of the items, which are counted from 1.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Selection {
    /// All.
    All,
    /// Every `count`-th, beginning with number `index`, counted from 1: neighbours, which often cost alike, go to different
    /// processes.
    Shard {
        /// Which of the shards.
        index: usize,
        /// How many shards there are.
        count: usize,
    },
    /// Those in one of the ranges.
    Items(Vec<RangeInclusive<usize>>),
}

const HELP: &str = "give --shard I/N with I from 1 to N";

impl Selection {
    /// `I/N`, or `auto`: what `variable` says of the variables that Slurm sets for a task of a job array, or Kubernetes for a
    /// pod of an indexed job (whose number of pods, JOB_COMPLETIONS, the job must hand on).
    pub fn shard(text: &str, variable: &dyn Fn(&str) -> Option<String>) -> Result<Selection> {
        if text == "auto" {
            return auto(variable);
        }
        let parts = text.split_once('/').map(|(index, count)| (index.parse(), count.parse()));
        match parts {
            Some((Ok(index), Ok(count))) if (1..=count).contains(&index) => Ok(Selection::Shard { index, count }),
            _ => Err(Error::usage(format!("--shard '{text}' is no share"), HELP)),
        }
    }

    /// Numbers and ranges, as Open Job Description writes them: `1-10`, `3`, `1-9:2`, `1-3,7`.
    pub fn items(text: &str) -> Result<Selection> {
        let ranges: Option<Vec<_>> = text.split(',').map(|part| range(part.trim())).collect();
        match ranges {
            Some(ranges) => Ok(Selection::Items(ranges.concat())),
            None => {
                let what = format!("--items '{text}' are no numbers of items");
                Err(Error::usage(what, "give numbers from 1 up and ranges: 1-10,15; --dry-run shows them"))
            }
        }
    }

    /// Is the item with this number part of it?
    pub fn holds(&self, number: usize) -> bool {
        match self {
            Selection::All => true,
            Selection::Shard { index, count } => (number - 1) % count == index - 1,
            Selection::Items(ranges) => ranges.iter().any(|range| range.contains(&number)),
        }
    }

    /// The largest number that was named.
    pub fn last(&self) -> Option<usize> {
        match self {
            Selection::Items(ranges) => ranges.iter().map(|range| *range.end()).max(),
            _ => None,
        }
    }
}

/// `3`, `1-10`, or every second, `1-9:2`, as one range a number.
fn range(text: &str) -> Option<Vec<RangeInclusive<usize>>> {
    let (bounds, step) = text.split_once(':').map_or((text, Some(1)), |(bounds, step)| (bounds, step.parse().ok()));
    let (first, last) = bounds.split_once('-').unwrap_or((bounds, bounds));
    let (first, last, step): (usize, usize, usize) = (first.parse().ok()?, last.parse().ok()?, step?);
    match (first, step) {
        _ if first == 0 || last < first => None,
        (_, 0) => None,
        (_, 1) => Some(vec![first..=last]),
        // Numbers that nobody can bake must not fill the memory.
        _ if (last - first) / step > 1_000_000 => None,
        _ => Some((first..=last).step_by(step).map(|n| n..=n).collect()),
    }
}

fn auto(variable: &dyn Fn(&str) -> Option<String>) -> Result<Selection> {
    let number = |name: &str| -> Result<Option<usize>> {
        variable(name)
            .map(|text| text.parse().map_err(|_| Error::usage(format!("{name} is '{text}', not a number"), HELP)))
            .transpose()
    };
    if let Some(id) = number("SLURM_ARRAY_TASK_ID")? {
        let (count, min) = (number("SLURM_ARRAY_TASK_COUNT")?, number("SLURM_ARRAY_TASK_MIN")?.unwrap_or(0));
        let step = number("SLURM_ARRAY_TASK_STEP")?.unwrap_or(1).max(1);
        let place = id.checked_sub(min).filter(|past| past.is_multiple_of(step)).map(|past| past / step);
        return match (place, count) {
            (Some(place), Some(count)) if place < count => Ok(Selection::Shard { index: place + 1, count }),
            _ => Err(Error::usage(format!("the job array has gaps: task {id} is not one of a regular series"), HELP)),
        };
    }
    if let Some(index) = number("JOB_COMPLETION_INDEX")? {
        return match number("JOB_COMPLETIONS")? {
            Some(count) if index < count => Ok(Selection::Shard { index: index + 1, count }),
            Some(count) => Err(Error::usage(format!("JOB_COMPLETION_INDEX is {index} of {count} completions"), HELP)),
            None => {
                let help = "set JOB_COMPLETIONS to the job's completions, or give --shard I/N";
                Err(Error::usage("JOB_COMPLETION_INDEX is set, but not JOB_COMPLETIONS", help))
            }
        };
    }
    Err(Error::usage("--shard auto finds neither SLURM_ARRAY_TASK_ID nor JOB_COMPLETION_INDEX", HELP))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn auto_of(set: &[(&str, &str)]) -> Result<Selection> {
        Selection::shard("auto", &|name| set.iter().find(|(n, _)| *n == name).map(|(_, v)| v.to_string()))
    }

    #[test]
    fn shards_are_disjoint_and_complete() {
        for count in 1..8 {
            let shards: Vec<_> =
                (1..=count).map(|i| Selection::shard(&format!("{i}/{count}"), &|_| None).unwrap()).collect();
            for item in 1..100 {
                assert_eq!(shards.iter().filter(|shard| shard.holds(item)).count(), 1, "{item} of {count}");
            }
        }
    }

    #[test]
    fn words_that_are_no_share_are_refused() {
        for text in ["0/3", "4/3", "1", "a/b", "1/0", "-1/2", ""] {
            assert!(Selection::shard(text, &|_| None).is_err(), "{text}");
        }
        for text in ["0", "3-1", "a", "", "1-", "1-5:0", "1,,2", "1-99999999999:2"] {
            assert!(Selection::items(text).is_err(), "{text}");
        }
    }

    #[test]
    fn items_are_numbers_ranges_and_steps() {
        let some = Selection::items("2, 5-6,10-14:2").unwrap();
        assert_eq!((1..20).filter(|n| some.holds(*n)).collect::<Vec<_>>(), [2, 5, 6, 10, 12, 14]);
        assert_eq!(some.last(), Some(14));
    }

    #[test]
    fn schedulers_say_which_shard_it_is() {
        let slurm = |id, min, step, count| {
            auto_of(&[
                ("SLURM_ARRAY_TASK_ID", id),
                ("SLURM_ARRAY_TASK_MIN", min),
                ("SLURM_ARRAY_TASK_STEP", step),
                ("SLURM_ARRAY_TASK_COUNT", count),
            ])
        };
        assert_eq!(slurm("0", "0", "1", "4").unwrap(), Selection::Shard { index: 1, count: 4 });
        assert_eq!(slurm("14", "10", "2", "5").unwrap(), Selection::Shard { index: 3, count: 5 });
        assert!(slurm("7", "1", "1", "2").unwrap_err().to_string().contains("gaps"));
        assert!(slurm("x", "1", "1", "2").unwrap_err().to_string().contains("SLURM_ARRAY_TASK_ID is 'x'"));
        let pod = [("JOB_COMPLETION_INDEX", "2"), ("JOB_COMPLETIONS", "3")];
        assert_eq!(auto_of(&pod).unwrap(), Selection::Shard { index: 3, count: 3 });
        assert!(auto_of(&pod[..1]).unwrap_err().help().contains("JOB_COMPLETIONS"));
        assert!(auto_of(&[]).unwrap_err().to_string().contains("finds neither"));
    }
}

//! Statistics of a simulation as columns of numbers.

use std::path::Path;

use relievo_core::{Error, Result, file};

use super::super::statistics::COLUMNS;

/// Bytes of a file at most.
const LONGEST: u64 = 1 << 28;

/// Columns of numbers, one for each name of [`COLUMNS`].
#[derive(Debug)]
pub struct Table(Vec<Vec<f64>>);

impl Table {
    /// Reads the statistics of a simulation. Fails, with the line, if they are not such, a number is not finite, or there
    /// are fewer than two frames. A last line without its end is left out, as one is written now.
    pub fn read(path: &Path) -> Result<Self> {
        let bytes = file::load(path, LONGEST)?;
        Self::parse(&bytes).map_err(|error| error.at(path.display().to_string()))
    }

    fn parse(bytes: &[u8]) -> Result<Self> {
        let text = std::str::from_utf8(bytes).map_err(|_| Error::invalid("it is not UTF-8 text"))?;
        let mut lines = text.split_inclusive('\n').filter_map(|line| line.strip_suffix('\n'));
        if lines.next().map(str::trim_end) != Some(&COLUMNS.join(",")) {
            return Err(Error::invalid("it does not begin with the columns of a simulation's statistics")
                .advise("name the statistics.csv that `relievo fluid sim` wrote, or its folder"));
        }
        let mut columns = vec![Vec::new(); COLUMNS.len()];
        for (number, line) in lines.enumerate() {
            let values = line.split(',').map(|text| text.trim().parse::<f64>().ok().filter(|value| value.is_finite()));
            let values: Option<Vec<f64>> = values.collect();
            let Some(values) = values.filter(|values| values.len() == columns.len()) else {
                return Err(Error::invalid(format!("there are not {} finite numbers", columns.len()))
                    .at(format!("line {}", number + 2))
                    .advise("remove the line"));
            };
            columns.iter_mut().zip(values).for_each(|(column, value)| column.push(value));
        }
        match columns[0].len() {
            0 | 1 => Err(Error::invalid("there are fewer than two frames").advise("simulate more")),
            _ => Ok(Self(columns)),
        }
    }

    /// How many frames there are.
    pub fn len(&self) -> usize {
        self.0[0].len()
    }

    /// The values of a name of [`COLUMNS`]; none of another.
    pub fn column(&self, name: &str) -> &[f64] {
        COLUMNS.iter().position(|column| *column == name).map_or(&[], |at| &self.0[at])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_are_no_statistics_is_refused_with_its_line() {
        let head = COLUMNS.join(",");
        let read = |rest: &str| Table::parse(format!("{head}\n{rest}").as_bytes());
        let row = "0,0,1,0,0,0,0,0,0\n";
        let table = read(&format!("{row}0.5,0.1,1,2,3,4,5,6,7\n1,0.2,1")).unwrap();
        assert_eq!((table.len(), table.column("frame"), table.column("none")), (2, &[0.0, 0.5][..], &[][..]));
        let refused = |rest: &str, why: &str| {
            let error = read(rest).unwrap_err().to_string();
            assert!(error.contains(why), "{error}");
        };
        refused(row, "two frames");
        refused(&format!("{row}1,2,3\n"), "line 3");
        refused(&format!("{row}1,0,1,0,0,nan,0,0,0\n"), "line 3");
        assert!(Table::parse(b"a,b\n1,2\n").is_err() && Table::parse(&[0xff]).is_err());
    }
}

//! Points from comma-separated values.

use super::table::{COLUMNS, MOST_POINTS, Table};

/// An error with its location.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Wrong {
    /// The error concerns the whole file.
    File(String),
    /// The error is in a line.
    Line(u64, String),
}

impl Wrong {
    /// The error on one line, with the name of the file.
    pub(crate) fn of(&self, file: &str) -> String {
        match self {
            Self::File(what) => format!("{file} {what}"),
            Self::Line(line, what) => format!("{file} line {line} {what}"),
        }
    }
}

/// Reads a header and rows with as many fields. Lines that begin with `#` and blanks around fields are ignored.
pub(super) fn read(bytes: &[u8]) -> Result<Table, Wrong> {
    let (mut columns, mut lines) = ([const { None }; COLUMNS.len()], Vec::new());
    let names = rows(bytes, "points", |names, line, row| {
        if lines.len() == MOST_POINTS {
            return Err(Wrong::File(format!("has more points than {MOST_POINTS}")));
        }
        for (column, values) in COLUMNS.iter().zip(&mut columns) {
            if let Some(place) = names.iter().position(|name| name == column) {
                let value = number(&row[place], line, (place, column))?;
                values.get_or_insert_with(Vec::new).push(value);
            }
        }
        lines.push(line);
        Ok(())
    })?;
    Ok(Table { names, columns, lines: Some(lines) })
}

/// Reads a header and passes its names with each row and its line; returns the names. `what` names the rows in messages.
pub(crate) fn rows(
    bytes: &[u8],
    what: &str,
    mut each: impl FnMut(&[String], u64, &::csv::StringRecord) -> Result<(), Wrong>,
) -> Result<Vec<String>, Wrong> {
    let mut reader = ::csv::ReaderBuilder::new()
        .trim(::csv::Trim::All)
        .comment(Some(b'#'))
        .flexible(true)
        .from_reader(bytes);
    let mut counted = Counted { bytes, at: 0, line: 1 };
    let head = reader.headers().map_err(|error| broken(&error, &mut counted))?;
    let names: Vec<String> = head.iter().map(str::to_owned).collect();
    if names.is_empty() {
        return Err(Wrong::File("is empty".to_owned()));
    }
    let mut is_empty = true;
    for row in reader.records() {
        let row = row.map_err(|error| broken(&error, &mut counted))?;
        let line = counted.line_of(row.position());
        if row.len() != names.len() {
            let what = format!("has {} fields; the head has {}", row.len(), names.len());
            return Err(Wrong::Line(line, what));
        }
        each(&names, line, &row)?;
        is_empty = false;
    }
    if is_empty {
        return Err(Wrong::File(format!("has a head and no {what}")));
    }
    Ok(names)
}

/// The number in a field, which is in a column with a name.
pub(crate) fn number(text: &str, line: u64, (place, name): (usize, &str)) -> Result<f64, Wrong> {
    text.parse().map_err(|_| {
        let what = if text.is_empty() { "empty".to_owned() } else { format!("`{text}`") };
        let column = place + 1;
        Wrong::Line(line, format!("column {column} (`{name}`) is {what}; it must be a number"))
    })
}

fn broken(error: &::csv::Error, counted: &mut Counted<'_>) -> Wrong {
    match error.kind() {
        ::csv::ErrorKind::Utf8 { err, pos } => {
            let column = err.field() + 1;
            Wrong::Line(counted.line_of(pos.as_ref()), format!("column {column} is no UTF-8"))
        }
        _ => Wrong::File(format!("cannot be read: {error}")),
    }
}

/// Lines counted so far.
///
/// The reader reports its position before a row: the end of the last row, before comments and empty lines.
struct Counted<'a> {
    bytes: &'a [u8],
    at: usize,
    line: u64,
}

impl Counted<'_> {
    fn line_of(&mut self, before: Option<&::csv::Position>) -> u64 {
        let before = before.and_then(|position| usize::try_from(position.byte()).ok());
        let before = before.unwrap_or(self.at);
        let mut in_comment = false;
        while let Some(byte) = self.bytes.get(self.at) {
            in_comment |= *byte == b'#';
            if self.at >= before && !in_comment && !matches!(byte, b'\r' | b'\n') {
                break;
            }
            if *byte == b'\n' {
                self.line += 1;
                in_comment = false;
            }
            self.at += 1;
        }
        self.line
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wrong(bytes: &[u8]) -> String {
        read(bytes).unwrap_err().of("points.csv")
    }

    #[test]
    fn columns_stand_in_any_order_among_others_and_rows_know_their_lines() {
        let text = "\u{feff}name, y ,x\r\n# two points\r\n a, 2, 1e-3\r\n\r\n\"b, c\",4, 3\r\n";
        let table = read(text.as_bytes()).unwrap();
        assert_eq!(table.names, ["name", "y", "x"]);
        assert_eq!(table.columns[0].as_deref(), Some([1e-3, 3.0].as_slice()));
        assert_eq!(table.columns[1].as_deref(), Some([2.0, 4.0].as_slice()));
        assert_eq!(table.columns[2], None);
        assert_eq!(table.lines, Some(vec![3, 5]));
    }

    #[test]
    fn fields_that_are_missing_many_or_no_text_are_told_with_their_line() {
        assert_eq!(wrong(b"\n\n"), "points.csv is empty");
        assert_eq!(wrong(b"x,y\n1,2,3\n"), "points.csv line 2 has 3 fields; the head has 2");
        let expected = "points.csv line 2 column 1 (`x`) is empty; it must be a number";
        assert_eq!(wrong(b"x,y\n,2\n"), expected);
        assert_eq!(wrong(b"x,y\n1,2\n1,\xff\n"), "points.csv line 3 column 2 is no UTF-8");
    }
}

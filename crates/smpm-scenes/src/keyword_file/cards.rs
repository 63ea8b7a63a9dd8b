//! Cards of a keyword file, chosen by keyword and id.

use std::collections::BTreeMap;

use scene_runs::scene::Objection;

/// Columns of a field.
const WIDTH: usize = 10;

/// A kind of card: its keyword by name and by number, and the names of the fields of each line, of which the first is the id.
pub(super) type CardKind = (&'static str, &'static str, &'static [&'static str]);

/// A keyword file that a key names.
#[derive(Debug)]
pub(crate) struct Cards<'t> {
    /// The key.
    pub(super) key: &'t str,
    /// The file.
    pub(super) file: &'t str,
    /// Keywords in upper case without `*` and `_TITLE`, each with the lines of its card and their numbers, from 1.
    blocks: Vec<(String, Vec<(usize, &'t str)>)>,
}

/// The numbers of a card.
#[derive(Debug)]
pub(super) struct Card {
    /// Keyword and id.
    pub(super) name: String,
    /// By field; those left out are 0.
    pub(super) numbers: BTreeMap<&'static str, f64>,
}

impl<'t> Cards<'t> {
    /// Splits a text into cards, without comments.
    pub(crate) fn of(text: &'t str, key: &'t str, file: &'t str) -> Self {
        let (mut blocks, mut has_title) = (Vec::<(String, Vec<_>)>::new(), false);
        for (i, line) in text.lines().enumerate().filter(|(_, line)| !line.starts_with('$')) {
            if let Some(word) = line.strip_prefix('*') {
                let word = word.trim_end().to_ascii_uppercase();
                has_title = word.ends_with("_TITLE");
                blocks.push((word.trim_end_matches("_TITLE").to_owned(), Vec::new()));
            } else if let Some((keyword, lines)) = blocks.last_mut()
                && ["MAT_", "EOS_"].iter().any(|start| keyword.starts_with(start))
                && !std::mem::take(&mut has_title)
            {
                lines.push((i + 1, line));
            }
        }
        Self { key, file, blocks }
    }

    /// The card of a kind with an id, or the only one.
    pub(super) fn card(&self, kind: CardKind, id: Option<u64>) -> Result<Card, Objection> {
        let (keyword, number, names) = kind;
        let objection =
            |message: String| Objection::new(self.key, format!("{} has {message}", self.file));
        let id_of = |lines: &[(usize, &str)]| fields(lines.first()?.1).first()?.parse::<u64>().ok();
        let all = self.blocks.iter().filter(|(it, _)| [keyword, number].contains(&it.as_str()));
        let all: Vec<_> = all.map(|(_, lines)| (id_of(lines), lines)).collect();
        if all.is_empty() {
            return Err(objection(format!("no *{keyword}")).with_help(self.listed()));
        }
        if self.blocks.iter().any(|(it, _)| it.starts_with("KEYWORD") && it.contains("LONG=Y")) {
            return Err(objection("the long format, which is not read".to_owned()));
        }
        let found: Vec<_> = all.iter().filter(|it| id.is_none() || it.0 == id).collect();
        let [(found_id, lines)] = found.as_slice() else {
            let word =
                |id: Option<u64>| id.map_or_else(|| "a label".to_owned(), |id| id.to_string());
            let ids: Vec<String> = all.iter().map(|it| word(it.0)).collect();
            let id_key = if keyword.starts_with("EOS") { "eosid" } else { "mid" };
            let with_id = id.map_or_else(String::new, |id| format!(" with the id {id}"));
            let help = format!("choose one by `{id_key}`: {}", ids.join(", "));
            return Err(objection(format!("{} *{keyword}{with_id}", found.len())).with_help(help));
        };
        let is_empty = |(_, line): &(usize, &str)| line.trim().is_empty();
        if lines.len() < names.len() || !lines[names.len()..].iter().all(is_empty) {
            let (n, read) = (lines.len(), names.len());
            return Err(objection(format!("{n} lines of *{keyword}; {read} are read")));
        }
        let mut numbers = BTreeMap::new();
        for (&(line, text), names) in lines.iter().zip(names) {
            let mut names = names.split_whitespace();
            for (i, field) in fields(text).iter().enumerate() {
                let (name, value) = (names.next().unwrap_or("field 9"), number_of(field));
                if let Some(value) = value.filter(|it| name != "field 9" || *it == 0.0) {
                    numbers.insert(name, value);
                } else if i > 0 || line != lines[0].0 {
                    let message = format!("{} line {line}: {name} cannot be read", self.file);
                    let help = "a field is a number in ten columns or up to a comma; there are at most eight, without parameters and expressions";
                    return Err(Objection::new(self.key, message).with_help(help));
                }
            }
        }
        let id = found_id.map_or_else(String::new, |id| format!(" {id}"));
        Ok(Card { name: format!("*{keyword}{id}"), numbers })
    }

    /// Keywords of materials and equations of state, for a message: nothing else of a file is shown.
    fn listed(&self) -> String {
        let is_word = |letter: &char| letter.is_ascii_alphanumeric() || "_+".contains(*letter);
        let starts = ["MAT_", "EOS_", "INCLUDE"];
        let own = self.blocks.iter().filter(|(it, _)| starts.iter().any(|of| it.starts_with(of)));
        let word = |it: &str| it.chars().take_while(is_word).take(60).collect::<String>();
        let mut words: Vec<String> = own.map(|(it, _)| format!("*{}", word(it))).collect();
        words.sort();
        words.dedup();
        words.truncate(20);
        let none = if words.is_empty() { "no *MAT_ and no *EOS_" } else { "" };
        format!("it has {none}{}; files that it includes are not read", words.join(", "))
    }
}

/// The fields of a line: between commas, or of equal width.
pub(super) fn fields(line: &str) -> Vec<String> {
    let letters: Vec<char> = line.trim_end().chars().collect();
    let field = |part: &[char]| part.iter().collect::<String>().trim().to_owned();
    if letters.contains(&',') {
        return letters.split(|&letter| letter == ',').map(field).collect();
    }
    letters.chunks(WIDTH).map(field).collect()
}

/// The number of a field, 0 of an empty one; also with the exponents of Fortran, `1.5d3` and `1.5+3`.
pub(super) fn number_of(field: &str) -> Option<f64> {
    let mut plain = field.to_ascii_lowercase().replace('d', "e");
    if !plain.bytes().all(|letter| letter.is_ascii_digit() || b"+-.e".contains(&letter)) {
        return None;
    }
    if let Some(sign) = plain.rfind(['+', '-']).filter(|&at| at > 0 && !plain.contains('e')) {
        plain.insert(sign, 'e');
    }
    if plain.is_empty() { Some(0.0) } else { plain.parse().ok().filter(|it: &f64| it.is_finite()) }
}

impl Card {
    /// The number of a field.
    pub(super) fn of(&self, field: &str) -> f64 {
        self.numbers.get(field).copied().unwrap_or(0.0)
    }
}

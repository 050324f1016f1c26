//! Names of columns from `CREATE TABLE`, as SQLite keeps it.

/// Token of SQL.
#[derive(Debug, Clone, PartialEq)]
enum SqlToken {
    Word(String),
    /// A name or text in quotation marks.
    Quoted(String),
    Sign(char),
}

impl SqlToken {
    fn is(&self, word: &str) -> bool {
        matches!(self, Self::Word(own) if own.eq_ignore_ascii_case(word))
    }
}

/// Names of the columns, and the place of the one that is the row's id; `None` for what is stored otherwise (virtual tables, tables
/// without row ids, computed columns).
pub(super) fn columns(sql: &str) -> Option<(Vec<String>, Option<usize>)> {
    let tokens = tokens(sql);
    let open = tokens.iter().position(|token| *token == SqlToken::Sign('('))?;
    if !tokens[..open].iter().any(|token| token.is("table"))
        || tokens[..open].iter().any(|token| token.is("virtual"))
    {
        return None;
    }

    let (mut definitions, mut depth) = (vec![Vec::new()], 1);
    let mut rest = tokens[open + 1..].iter();
    for token in rest.by_ref() {
        match token {
            SqlToken::Sign('(') => depth += 1,
            SqlToken::Sign(')') => depth -= 1,
            _ => {}
        }
        match (token, depth) {
            (_, 0) => break,
            (SqlToken::Sign(','), 1) => definitions.push(Vec::new()),
            _ => definitions.last_mut()?.push(token.clone()),
        }
    }

    if depth != 0 || rest.any(|token| token.is("rowid")) {
        return None;
    }

    let (mut names, mut id) = (Vec::new(), None);
    let mut key = None;
    for definition in definitions {
        let has = |word: &str| definition.iter().any(|token| token.is(word));
        match definition.first()? {
            SqlToken::Word(word)
                if ["constraint", "primary", "unique", "check", "foreign"]
                    .iter()
                    .any(|constraint| word.eq_ignore_ascii_case(constraint)) =>
            {
                if has("primary") {
                    key = key_of(&definition);
                }
            }
            SqlToken::Word(name) | SqlToken::Quoted(name) => {
                if has("as") || has("generated") {
                    return None;
                }
                let is_integer = definition.get(1).is_some_and(|kind| kind.is("integer"));
                if is_integer && has("primary") {
                    id = Some(names.len());
                }
                names.push((name.clone(), is_integer));
            }
            SqlToken::Sign(_) => return None,
        }
    }

    // A key of one integer column is the row's id as well, wherever it is said.
    let keyed =
        |key: &String| names.iter().position(|(name, integer)| *integer && name.eq_ignore_ascii_case(key));
    let id = id.or_else(|| key.as_ref().and_then(keyed));

    Some((names.into_iter().map(|(name, _)| name).collect(), id))
}

/// The one column of `PRIMARY KEY (…)`.
fn key_of(definition: &[SqlToken]) -> Option<String> {
    let open = definition.iter().position(|token| *token == SqlToken::Sign('('))?;
    match &definition[open + 1..] {
        [SqlToken::Word(name) | SqlToken::Quoted(name), rest @ ..]
            if !rest.contains(&SqlToken::Sign(',')) =>
        {
            Some(name.clone())
        }
        _ => None,
    }
}

fn tokens(sql: &str) -> Vec<SqlToken> {
    let mut tokens = Vec::new();
    let mut rest = sql.chars().peekable();
    while let Some(character) = rest.next() {
        match character {
            '"' | '`' | '\'' | '[' => {
                let end = if character == '[' { ']' } else { character };
                let mut text = String::new();
                while let Some(next) = rest.next() {
                    if next == end {
                        // Doubled, it stands for itself.
                        if end == ']' || rest.next_if_eq(&end).is_none() {
                            break;
                        }
                    }
                    text.push(next);
                }

                tokens.push(SqlToken::Quoted(text));
            }
            '-' if rest.next_if_eq(&'-').is_some() => while rest.next_if(|next| *next != '\n').is_some() {},
            '/' if rest.next_if_eq(&'*').is_some() => {
                let mut before = ' ';
                for next in rest.by_ref() {
                    if before == '*' && next == '/' {
                        break;
                    }
                    before = next;
                }
            }
            letter if letter.is_alphanumeric() || letter == '_' => {
                let mut word = String::from(letter);
                while let Some(next) =
                    rest.next_if(|next| next.is_alphanumeric() || *next == '_' || *next == '$')
                {
                    word.push(next);
                }
                tokens.push(SqlToken::Word(word));
            }
            space if space.is_whitespace() => {}
            sign => tokens.push(SqlToken::Sign(sign)),
        }
    }

    tokens
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(sql: &str) -> Option<(Vec<String>, Option<usize>)> {
        columns(sql)
    }

    #[test]
    fn columns_are_found_in_what_programs_write() {
        let names = |names: &[&str]| names.iter().map(|name| (*name).to_owned()).collect::<Vec<_>>();
        let gdal = "CREATE TABLE \"roads\" ( \"fid\" INTEGER PRIMARY KEY AUTOINCREMENT NOT NULL, \"geom\" LINESTRING, \"a, b\" TEXT(80), width REAL DEFAULT (1.0))";
        assert_eq!(found(gdal), Some((names(&["fid", "geom", "a, b", "width"]), Some(0))));
        let keyed = "CREATE TABLE t(a TEXT -- b, c\n, [id x] INTEGER, /* d, */ e DECIMAL(5,2), CONSTRAINT k PRIMARY KEY (\"id x\"))";
        assert_eq!(found(keyed), Some((names(&["a", "id x", "e"]), Some(1))));
        assert_eq!(
            found("CREATE TABLE t(a INT PRIMARY KEY, 'it''s' TEXT)"),
            Some((names(&["a", "it's"]), None))
        );
    }

    #[test]
    fn what_is_stored_otherwise_is_not_read() {
        for sql in [
            "CREATE VIRTUAL TABLE t USING rtree(id, a, b)",
            "CREATE TABLE t(a TEXT PRIMARY KEY) WITHOUT ROWID",
            "CREATE TABLE t(a INTEGER, b INTEGER GENERATED ALWAYS AS (a * 2))",
            "CREATE TABLE t(a INTEGER",
            "CREATE TABLE t(a,,b)",
            "",
        ] {
            assert_eq!(found(sql), None, "{sql}");
        }
    }
}

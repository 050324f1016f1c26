//! Tables of settings as text that people can edit, and back.

use hedgehop_base::error::{Error, Result};
use serde::Serialize;
use serde::de::DeserializeOwned;
use toml::{Table, Value};

/// Writes a table as TOML: values first, then tables within it by their names.
///
/// # Errors
///
/// Dates, or arrays of tables: no table of settings has them.
pub fn to_text(settings: &impl Serialize) -> Result<String> {
    let table = table_of(settings)?;
    let mut text = String::new();
    write_table(&table, "", &mut text);
    Ok(text)
}

/// Reads a table from TOML; `what` names it in errors.
///
/// # Errors
///
/// The text is no TOML, or a key is unknown, missing or of another kind.
pub fn from_text<T: DeserializeOwned>(text: &str, what: &str) -> Result<T> {
    toml::from_str(text).map_err(|error| fault(what, &error))
}

/// Reads a table anew with some values changed by a text such as `aircraft.altitude_ft = 300`.
///
/// # Errors
///
/// As of [`from_text`].
pub fn changed<T: Serialize + DeserializeOwned>(settings: &T, change: &str, what: &str) -> Result<T> {
    let mut table = table_of(settings)?;
    merge(&mut table, from_text(change, what)?);
    table.try_into().map_err(|error| fault(what, &error))
}

fn table_of(settings: &impl Serialize) -> Result<Table> {
    Table::try_from(settings)
        .map_err(|error| Error::Configuration(format!("a table cannot be written: {error}")))
}

fn fault(what: &str, error: &toml::de::Error) -> Error {
    Error::Configuration(format!("{what}: {}", error.message().trim().replace('\n', ", ")))
}

/// Lays one table over another, key by key.
fn merge(under: &mut Table, over: Table) {
    for (key, value) in over {
        match (under.get_mut(&key), value) {
            (Some(Value::Table(under)), Value::Table(over)) => merge(under, over),
            (_, value) => {
                under.insert(key, value);
            }
        }
    }
}

fn write_table(table: &Table, name: &str, text: &mut String) {
    for (key, value) in table {
        if !value.is_table() {
            text.push_str(&format!("{key} = {}\n", value_text(value)));
        }
    }
    for (key, value) in table {
        if let Value::Table(inner) = value {
            let name = if name.is_empty() { key.clone() } else { format!("{name}.{key}") };
            text.push_str(&format!("\n[{name}]\n"));
            write_table(inner, &name, text);
        }
    }
}

fn value_text(value: &Value) -> String {
    match value {
        Value::Array(values) => {
            format!("[{}]", values.iter().map(value_text).collect::<Vec<_>>().join(", "))
        }
        // Rust escapes quotes, backslashes and ends of lines as TOML does.
        Value::String(text) => format!("{text:?}"),
        // With a point, so that numbers stay real ones.
        Value::Float(number) => format!("{number:?}"),
        Value::Integer(number) => number.to_string(),
        Value::Boolean(flag) => flag.to_string(),
        Value::Datetime(_) | Value::Table(_) => String::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_come_back_from_their_text() {
        let text = "a = 1\nb = -0.25\nc = \"x \\\"y\\\"\"\nd = [1.0, 2.5]\n\n[e]\nf = true\n\n[e.g]\nh = 3\n";
        let table: Table = from_text(text, "a table").unwrap();
        assert_eq!(to_text(&table).unwrap(), text);
        let other = changed(&table, "e.g.h = 4\nb = 1.0", "a table").unwrap();
        assert_eq!(to_text(&other).unwrap(), text.replace("h = 3", "h = 4").replace("-0.25", "1.0"));
    }
}

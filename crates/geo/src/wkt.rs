//! Well-known text: the grammar.
//!
//! Sources: OGC 01-009 (*Coordinate Transformation Services*, 2001, §7: WKT 1) and OGC 18-010r11 (*Well-known text
//! representation of coordinate reference systems*, 2023: WKT 2). One grammar serves both:
//!
//! ```text
//! text = node [ "," node ]                     (Esri: a horizontal and a vertical system)
//! node = WORD ( "[" | "(" ) item { "," item } ( "]" | ")" )
//! item = node | "text" | number | WORD
//! ```
//!
//! What a tree means is in `wkt_system`.

/// Deepest nesting that is read; real texts stay below 10.
const DEEPEST: usize = 40;

/// Longest text that is read, in bytes.
const LONGEST: usize = 1 << 20;

/// First words of texts that are meant as WKT.
const ROOTS: [&str; 21] = [
    "PROJCS",
    "GEOGCS",
    "COMPD_CS",
    "GEOCCS",
    "LOCAL_CS",
    "VERT_CS",
    "VERTCS",
    "FITTED_CS",
    "PROJCRS",
    "PROJECTEDCRS",
    "GEOGCRS",
    "GEOGRAPHICCRS",
    "GEODCRS",
    "GEODETICCRS",
    "COMPOUNDCRS",
    "BOUNDCRS",
    "VERTCRS",
    "VERTICALCRS",
    "ENGCRS",
    "ENGINEERINGCRS",
    "DERIVEDPROJCRS",
];

/// Words of vertical systems.
pub(super) const VERTICAL: [&str; 4] = ["VERT_CS", "VERTCS", "VERTCRS", "VERTICALCRS"];

/// Whether a text begins like WKT.
pub(super) fn looks_like_wkt(text: &str) -> bool {
    let end = text.find(['[', '(']).unwrap_or(0);
    let word = text.get(..end).unwrap_or("").trim();
    ROOTS.iter().any(|root| root.eq_ignore_ascii_case(word))
}

/// A node of the tree.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Node {
    /// Upper case.
    pub(super) word: String,
    pub(super) items: Vec<Item>,
}

/// Item between commas.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Item {
    Node(Node),
    Text(String),
    Number(f64),
    Word(String),
}

impl Node {
    /// The children of any of these words.
    pub(super) fn children<'a>(&'a self, words: &'a [&str]) -> impl Iterator<Item = &'a Node> {
        self.items.iter().filter_map(move |item| match item {
            Item::Node(node) if words.contains(&node.word.as_str()) => Some(node),
            _ => None,
        })
    }

    /// The first child of any of these words.
    pub(super) fn child<'a>(&'a self, words: &'a [&str]) -> Option<&'a Node> {
        self.children(words).next()
    }

    /// The name: the first item, if it is a text.
    pub(super) fn name(&self) -> &str {
        match self.items.first() {
            Some(Item::Text(text)) => text,
            _ => "",
        }
    }

    /// The numbers among the items, in order; each is finite.
    pub(super) fn numbers(&self) -> impl Iterator<Item = f64> {
        self.items.iter().filter_map(|item| match item {
            Item::Number(number) => Some(*number),
            _ => None,
        })
    }

    /// Code of `AUTHORITY["EPSG","4326"]` or `ID["EPSG",4326]`, for one authority.
    pub(super) fn code(&self, authority: &str) -> Option<u32> {
        let node =
            self.children(&["AUTHORITY", "ID"]).find(|node| node.name().eq_ignore_ascii_case(authority))?;
        match node.items.get(1)? {
            Item::Text(text) | Item::Word(text) => text.trim().parse().ok(),
            // The comparison keeps the cast exact.
            Item::Number(number) if number.fract() == 0.0 && (1.0..1e9).contains(number) => {
                Some(*number as u32)
            }
            _ => None,
        }
    }
}

/// Reads a text into its tree.
pub(super) fn parse(text: &str) -> Result<Node, String> {
    if text.len() > LONGEST {
        return Err(format!("a WKT of {} bytes is too long (the limit is {LONGEST})", text.len()));
    }

    let mut parser = Parser { text, place: 0 };
    let word = parser.word()?;
    let root = parser.node(word, 0)?;
    parser.skip_space();
    if parser.peek() != Some(',') {
        return parser.ended(root);
    }

    // Esri writes the vertical system behind the horizontal one.
    parser.place += 1;
    let word = parser.word()?;
    if !VERTICAL.iter().any(|vertical| vertical.eq_ignore_ascii_case(&word)) {
        return Err(parser.error("a second system that is no vertical one before it"));
    }

    let vertical = parser.node(word, 0)?;
    parser.skip_space();
    let name = Item::Text(root.name().to_owned());

    parser.ended(Node { word: "COMPD_CS".into(), items: vec![name, Item::Node(root), Item::Node(vertical)] })
}

struct Parser<'a> {
    text: &'a str,
    place: usize,
}

impl Parser<'_> {
    /// The tree, if nothing comes after it.
    fn ended(&self, root: Node) -> Result<Node, String> {
        if self.place < self.text.len() {
            return Err(self.error("text after the closing bracket"));
        }
        Ok(root)
    }

    fn rest(&self) -> &str {
        self.text.get(self.place..).unwrap_or("")
    }

    fn peek(&self) -> Option<char> {
        self.rest().chars().next()
    }

    fn skip_space(&mut self) {
        let rest = self.rest();
        self.place += rest.len() - rest.trim_start_matches(|c: char| c.is_whitespace() || c == '\0').len();
    }

    fn error(&self, what: &str) -> String {
        format!(
            "the WKT has {what} at character {}; write a sound one with: gdalsrsinfo -o wkt1 EPSG:CODE",
            self.text.get(..self.place).unwrap_or("").chars().count() + 1
        )
    }

    /// A word or a number, as it stands.
    fn word(&mut self) -> Result<String, String> {
        self.skip_space();
        let rest = self.rest();
        let end = rest.find(|c: char| !(c.is_alphanumeric() || "_+-.:".contains(c))).unwrap_or(rest.len());
        let word = rest.get(..end).unwrap_or("").to_owned();
        if word.is_empty() {
            return Err(self.error(if rest.is_empty() {
                "no end: it breaks off"
            } else {
                "an unexpected character"
            }));
        }
        self.place += end;
        Ok(word)
    }

    fn quoted(&mut self) -> Result<String, String> {
        let start = self.place;
        let mut text = String::new();
        let mut characters = self.rest().char_indices().skip(1).peekable();
        while let Some((at, character)) = characters.next() {
            if character != '"' {
                text.push(character);
            } else if characters.peek().is_some_and(|(_, next)| *next == '"') {
                text.push('"');
                characters.next();
            } else {
                self.place = start + at + 1;
                return Ok(text);
            }
        }
        Err(self.error("a text without closing quote"))
    }

    fn node(&mut self, word: String, depth: usize) -> Result<Node, String> {
        self.skip_space();
        let close = match self.peek() {
            Some('[') => ']',
            Some('(') => ')',
            _ => return Err(self.error("no bracket after a keyword")),
        };
        if depth > DEEPEST {
            return Err(self.error("too many brackets within each other"));
        }

        self.place += 1;
        let mut items = Vec::new();
        loop {
            items.push(self.item(depth)?);
            self.skip_space();
            match self.peek() {
                Some(',') => self.place += 1,
                Some(c) if c == close => {
                    self.place += 1;
                    return Ok(Node { word: word.to_ascii_uppercase(), items });
                }
                None => return Err(self.error("no end: it breaks off")),
                Some(_) => return Err(self.error("neither comma nor closing bracket")),
            }
        }
    }

    fn item(&mut self, depth: usize) -> Result<Item, String> {
        self.skip_space();
        if self.peek() == Some('"') {
            return self.quoted().map(Item::Text);
        }
        let word = self.word()?;
        self.skip_space();
        if matches!(self.peek(), Some('[' | '(')) {
            return self.node(word, depth + 1).map(Item::Node);
        }
        let numeric = word.starts_with(|c: char| c.is_ascii_digit() || "+-.".contains(c));
        match word.parse::<f64>() {
            Ok(number) if numeric && number.is_finite() => Ok(Item::Number(number)),
            _ => Ok(Item::Word(word)),
        }
    }
}

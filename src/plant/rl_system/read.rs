//! Grammars out of text.

use std::collections::BTreeMap;

use super::expression::{Expression, Step, function, number, operator};
use super::lexer::{Placed, Token, tokens};
use super::object::{Object, ObjectForm};
use super::turtle::Turn;
use super::{Command, Item, RLS_SCHEMA, RlSystem, Rule};
use crate::document::{Document, DocumentError};
use crate::limits;
use crate::math::{Stream, index_u32};
use crate::plant::Silhouette;

/// Words that begin a statement.
const STATEMENTS: [&str; 12] = [
    "schema",
    "name",
    "latin",
    "stop_leaves",
    "steps",
    "let",
    "bark",
    "leaf",
    "flower",
    "fruit",
    "axiom",
    "rule",
];

/// Reads a grammar.
pub(super) fn parse(document: &Document) -> Result<RlSystem, DocumentError> {
    let tokens = tokens(document)?;
    let mut reader = Reader {
        document,
        names: declared(&tokens),
        tokens,
        next: 0,
        lets: BTreeMap::new(),
        parameters: Vec::new(),
    };
    reader.system()
}

/// The modules that rules rewrite, with how many parameters they have, in the order of their rules: known
/// before successors are read, which may name later ones.
fn declared(tokens: &[Placed]) -> Vec<(String, usize)> {
    let mut names: Vec<(String, usize)> = Vec::new();
    for (place, pair) in tokens.windows(2).enumerate() {
        let (Token::Word(first), Token::Word(name)) = (&pair[0].token, &pair[1].token) else {
            continue;
        };
        if first == "rule" && !names.iter().any(|(known, _)| known == name) {
            let after = tokens[place + 2..].iter().map(|placed| &placed.token);
            let inside = after
                .take_while(|token| !matches!(token, Token::Sign(")" | "->" | ":") | Token::End));
            let count = inside
                .filter(|token| matches!(token, Token::Word(_)))
                .count();
            names.push((name.clone(), count));
        }
    }
    names
}

/// A grammar that is being read.
pub(super) struct Reader<'a> {
    pub(super) document: &'a Document,
    pub(super) tokens: Vec<Placed>,
    pub(super) next: usize,
    names: Vec<(String, usize)>,
    lets: BTreeMap<String, f32>,
    /// Those of the rule that is being read.
    parameters: Vec<String>,
}

impl Reader<'_> {
    fn system(&mut self) -> Result<RlSystem, DocumentError> {
        let mut system = RlSystem {
            document: self.document.clone(),
            name: String::new(),
            latin: String::new(),
            stop_leaves: None,
            steps: 0,
            bark: [0x6b, 0x5d, 0x4d],
            edges: [8, 6, 4, 3],
            objects: Vec::new(),
            axiom: Vec::new(),
            rules: vec![Vec::new(); self.names.len()],
        };
        self.word("schema")?;
        let (offset, schema) = self.text()?;
        if schema != RLS_SCHEMA {
            let message = format!("schema is {schema:?}, wanted {RLS_SCHEMA:?}");
            return Err(self.document.error(offset, message));
        }
        loop {
            let Placed { token, offset } = self.take();
            let word = match &token {
                Token::End => break,
                Token::Word(word) => word.as_str(),
                _ => "",
            };
            match word {
                "name" => system.name = self.text()?.1,
                "latin" => system.latin = self.text()?.1,
                "stop_leaves" => {
                    let most = index_u32(limits::GROWN_LEAVES);
                    system.stop_leaves = Some(self.whole("stop_leaves", 1, most)?);
                }
                "steps" => system.steps = self.whole("steps", 1, limits::RL_STEPS)?,
                "let" => self.constant()?,
                "bark" => self.bark(&mut system)?,
                "leaf" | "flower" | "fruit" => {
                    let object = self.object(word, &system.objects)?;
                    system.objects.push(object);
                }
                "axiom" => {
                    if !system.axiom.is_empty() {
                        return Err(self.document.error(offset, "a second axiom, wanted one"));
                    }
                    self.parameters.clear();
                    system.axiom = self.successor(&system.objects)?;
                }
                "rule" => self.rule(&mut system)?,
                _ => {
                    let (found, wanted) = (token.shown(), STATEMENTS.join(", "));
                    let message = format!("{found} begins no statement, wanted one of {wanted}");
                    return Err(self.document.error(offset, message));
                }
            }
        }
        let missing = [
            ("name", system.name.trim().is_empty()),
            ("steps", system.steps == 0),
            ("axiom", system.axiom.is_empty()),
        ];
        match missing.iter().find(|(_, is_missing)| *is_missing) {
            Some((what, _)) => Err(self.document.error(
                self.document.text.len(),
                format!(
                    "the file ends without {what}, wanted a statement {what:?} that says something"
                ),
            )),
            None => Ok(system),
        }
    }

    fn constant(&mut self) -> Result<(), DocumentError> {
        let (offset, name) = self.any_word("a name")?;
        self.sign("=")?;
        self.parameters.clear();
        let value = self.expression(0, 0)?;
        if value
            .steps
            .iter()
            .any(|step| matches!(step, Step::Uniform | Step::Normal))
        {
            let message = format!("let {name} is random, wanted rnd and nrm within rules alone");
            return Err(self.document.error(offset, message));
        }
        let mut draws = Stream::new(0, 0).draws();
        let value = value.value(&[], &mut draws, &mut Vec::new());
        self.lets.insert(name, value);
        Ok(())
    }

    fn bark(&mut self, system: &mut RlSystem) -> Result<(), DocumentError> {
        self.sign("{")?;
        while !self.accepts("}") {
            let (offset, key) = self.any_word("color or edges")?;
            match key.as_str() {
                "color" => system.bark = self.color()?,
                "edges" => {
                    for place in 0..4 {
                        let offset = self.peek().offset;
                        let edges = self.whole("edges", 0, 64)?;
                        if (1..3).contains(&edges) {
                            let message = format!("{edges} edges, wanted 0 or at least 3");
                            return Err(self.document.error(offset, message));
                        }
                        system.edges[place] = edges;
                    }
                }
                _ => return Err(self.unknown_key(offset, &key, "color and four edges")),
            }
        }
        Ok(())
    }

    fn object(&mut self, kind: &str, known: &[Object]) -> Result<Object, DocumentError> {
        let (offset, name) = self.any_word("a name")?;
        if known.iter().any(|object| object.name == name) {
            let message = format!("a second {name}, wanted another name");
            return Err(self.document.error(offset, message));
        }
        if known.len() >= limits::SPECIES_KINDS {
            let message = format!("more than {} kinds of organs", limits::SPECIES_KINDS);
            return Err(self.document.error(offset, message));
        }
        let (mut silhouette, mut petals) = (Silhouette::Elliptic, 5);
        let mut object = Object {
            name,
            form: ObjectForm::Fruit,
            width: 0.6,
            color: [0x4f, 0x7a, 0x2c],
        };
        self.sign("{")?;
        while !self.accepts("}") {
            let (offset, key) = self.any_word("a key")?;
            match (key.as_str(), kind) {
                ("color", _) => object.color = self.color()?,
                ("width", _) => object.width = self.number("width", 0.02, 5.0)?,
                ("silhouette", "leaf" | "flower") => {
                    let (offset, name) = self.text()?;
                    let found = Silhouette::ALL.iter().find(|image| image.name() == name);
                    silhouette = *found.ok_or_else(|| {
                        let all = Silhouette::ALL.map(Silhouette::name).join(", ");
                        let message = format!("silhouette is {name:?}, wanted one of {all}");
                        self.document.error(offset, message)
                    })?;
                }
                ("petals", "flower") => petals = self.whole("petals", 1, 32)?,
                _ => {
                    let wanted = match kind {
                        "leaf" => "color, width and silhouette",
                        "flower" => "color, width, silhouette and petals",
                        _ => "color and width",
                    };
                    return Err(self.unknown_key(offset, &key, wanted));
                }
            }
        }
        object.form = match kind {
            "leaf" => ObjectForm::Leaf(silhouette),
            "flower" => ObjectForm::Flower(silhouette, petals),
            _ => ObjectForm::Fruit,
        };
        Ok(object)
    }

    fn rule(&mut self, system: &mut RlSystem) -> Result<(), DocumentError> {
        let (offset, name) = self.any_word("the module that it rewrites")?;
        self.parameters.clear();
        if self.accepts("(") {
            loop {
                let (_, parameter) = self.any_word("the name of a parameter")?;
                self.parameters.push(parameter);
                if !self.accepts(",") {
                    break;
                }
            }
            self.sign(")")?;
        }
        let place = self.names.iter().position(|(known, _)| *known == name);
        let place = place.expect("all names after rule were collected");
        let (found, wanted) = (self.parameters.len(), self.names[place].1);
        if found != wanted {
            let message =
                format!("{name} has {found} parameters here, wanted {wanted} as in its first rule");
            return Err(self.document.error(offset, message));
        }
        let condition = if self.accepts(":") {
            Some(self.expression(0, 0)?)
        } else {
            None
        };
        let weight = if self.accepts("@") {
            self.number("the weight", 0.0, 1e6)?
        } else {
            1.0
        };
        self.sign("->")?;
        let successor = self.successor(&system.objects)?;
        system.rules[place].push(Rule {
            condition,
            weight,
            successor,
        });
        Ok(())
    }

    /// Modules and commands up to the next statement.
    fn successor(&mut self, objects: &[Object]) -> Result<Vec<Item>, DocumentError> {
        let mut items = Vec::new();
        let mut open: Vec<usize> = Vec::new();
        loop {
            let Placed { token, offset } = self.peek().clone();
            let ends = match &token {
                Token::End => true,
                Token::Word(word) => STATEMENTS.contains(&word.as_str()),
                _ => false,
            };
            if ends {
                return match open.pop() {
                    Some(open) => Err(self
                        .document
                        .error(open, "a [ that is not closed, wanted a ]")),
                    None => Ok(items),
                };
            }
            self.next += 1;
            let (module, command, counts) = self.command(&token, offset, objects)?;
            match command {
                Command::Push => open.push(offset),
                Command::Pop if open.pop().is_none() => {
                    return Err(self.document.error(offset, "a ] without its ["));
                }
                _ => {}
            }
            let arguments = self.arguments()?;
            if !counts.contains(&arguments.len()) {
                let wanted: Vec<String> = counts.iter().map(ToString::to_string).collect();
                let message = format!(
                    "{} has {} numbers in parentheses, wanted {}",
                    token.shown(),
                    arguments.len(),
                    wanted.join(" or ")
                );
                return Err(self.document.error(offset, message));
            }
            items.push(Item {
                module,
                command,
                arguments,
                offset,
            });
        }
    }

    /// What a token in a successor does: the module that rules rewrite, what the turtle does otherwise, and
    /// how many numbers may follow.
    fn command(
        &mut self,
        token: &Token,
        offset: usize,
        objects: &[Object],
    ) -> Result<(Option<u32>, Command, Vec<usize>), DocumentError> {
        let plain = |command, counts: &[usize]| Ok((None, command, counts.to_vec()));
        match token {
            Token::Sign("[") => plain(Command::Push, &[0]),
            Token::Sign("]") => plain(Command::Pop, &[0]),
            Token::Sign("|") => plain(Command::About, &[0]),
            Token::Sign("$") => plain(Command::Level, &[0]),
            Token::Sign("!") => plain(Command::Radius, &[1]),
            Token::Sign("+") => plain(Command::Turn(Turn::Left), &[1]),
            Token::Sign("-") => plain(Command::Turn(Turn::Right), &[1]),
            Token::Sign("&") => plain(Command::Turn(Turn::Down), &[1]),
            Token::Sign("^") => plain(Command::Turn(Turn::Up), &[1]),
            Token::Sign("\\") => plain(Command::Turn(Turn::RollLeft), &[1]),
            Token::Sign("/") => plain(Command::Turn(Turn::RollRight), &[1]),
            Token::Sign("~") => {
                let (offset, name) = self.any_word("a leaf, flower or fruit")?;
                let place = objects.iter().position(|object| object.name == name);
                let place = place.ok_or_else(|| {
                    let known: Vec<&str> =
                        objects.iter().map(|object| object.name.as_str()).collect();
                    let known = known.join(", ");
                    let message =
                        format!("~{name} is declared nowhere above, wanted one of: {known}");
                    self.document.error(offset, message)
                })?;
                plain(Command::Place(index_u32(place)), &[1])
            }
            Token::Word(word) => {
                let (command, counts): (_, &[usize]) = match word.as_str() {
                    "F" => (Command::Draw, &[1, 2]),
                    "f" => (Command::Walk, &[1]),
                    "T" => (Command::Turn(Turn::Lift), &[1]),
                    _ => (Command::Nothing, &[]),
                };
                let rules = self.names.iter().position(|(name, _)| name == word);
                match rules {
                    Some(rules) => {
                        let count = self.names[rules].1;
                        if command != Command::Nothing && !counts.contains(&count) {
                            let message =
                                format!("rules give {word} {count} parameters, wanted {counts:?}");
                            return Err(self.document.error(offset, message));
                        }
                        Ok((Some(index_u32(rules)), command, vec![count]))
                    }
                    None if command == Command::Nothing => {
                        let message = format!(
                            "{word} has no rule and is no command (F, f, T), wanted a rule for it"
                        );
                        Err(self.document.error(offset, message))
                    }
                    None => plain(command, counts),
                }
            }
            _ => {
                let message = format!("{} is no module and no command", token.shown());
                Err(self.document.error(offset, message))
            }
        }
    }

    fn arguments(&mut self) -> Result<Vec<Expression>, DocumentError> {
        let mut arguments = Vec::new();
        if self.accepts("(") {
            loop {
                arguments.push(self.expression(0, 0)?);
                if !self.accepts(",") {
                    break;
                }
            }
            self.sign(")")?;
        }
        Ok(arguments)
    }

    /// An expression whose operators bind more strongly than `least`.
    fn expression(&mut self, least: u8, nesting: usize) -> Result<Expression, DocumentError> {
        let mut steps = self.operand(nesting)?;
        loop {
            let sign = match &self.peek().token {
                Token::Sign(sign) => *sign,
                Token::Word(word) => word.as_str(),
                _ => "",
            };
            match operator(sign) {
                Some((strength, step)) if strength > least => {
                    self.next += 1;
                    steps.extend(self.expression(strength, nesting + 1)?.steps);
                    steps.push(step);
                }
                _ => return Ok(Expression { steps }),
            }
        }
    }

    fn operand(&mut self, nesting: usize) -> Result<Vec<Step>, DocumentError> {
        let Placed { token, offset } = self.take();
        if nesting > limits::RL_NESTING {
            let message = format!("an expression nested more than {} deep", limits::RL_NESTING);
            return Err(self.document.error(offset, message));
        }
        match &token {
            Token::Number(number) => Ok(vec![Step::Number(*number)]),
            Token::Sign("-") => {
                let mut steps = self.operand(nesting + 1)?;
                steps.push(Step::One(|value| -value));
                Ok(steps)
            }
            Token::Sign("(") => {
                let inside = self.expression(0, nesting + 1)?;
                self.sign(")")?;
                Ok(inside.steps)
            }
            Token::Word(word) if word == "not" => {
                let mut steps = self.operand(nesting + 1)?;
                steps.push(Step::One(|value| number(value == 0.0)));
                Ok(steps)
            }
            Token::Word(word) => self.named(word, offset, nesting),
            _ => {
                let message = format!("{} is no number, wanted an expression", token.shown());
                Err(self.document.error(offset, message))
            }
        }
    }

    /// A parameter, a constant or a function.
    fn named(
        &mut self,
        word: &str,
        offset: usize,
        nesting: usize,
    ) -> Result<Vec<Step>, DocumentError> {
        if let Some(place) = self.parameters.iter().position(|name| name == word) {
            return Ok(vec![Step::Parameter(place)]);
        }
        if let Some(value) = self.lets.get(word) {
            return Ok(vec![Step::Number(*value)]);
        }
        let Some((count, step)) = function(word) else {
            let message = format!(
                "{word} is no parameter of this rule, no let above and no function; wanted one of {}, \
                 or rnd, nrm, min, max, pow, abs, sqrt, floor, sin, cos",
                if self.parameters.is_empty() {
                    "(no parameters)".to_owned()
                } else {
                    self.parameters.join(", ")
                }
            );
            return Err(self.document.error(offset, message));
        };
        self.sign("(")?;
        let mut steps = self.expression(0, nesting + 1)?.steps;
        for _ in 1..count {
            self.sign(",")?;
            steps.extend(self.expression(0, nesting + 1)?.steps);
        }
        self.sign(")")?;
        steps.push(step);
        Ok(steps)
    }
}

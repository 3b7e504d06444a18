//! The texts of `tmcl explain`: each is whole, and its examples do what it says of them.

use tmcl_lang::{Code, Diagnostic, Resolved, Resolver, SourceFile, assemble, lint};

/// What the file of an example is called; E0302 needs to know.
const FILE: &str = "Motion.tmc";

/// The only file there is, besides the built-in ones, is the example itself.
struct Itself<'a>(&'a str);

impl Resolver for Itself<'_> {
    fn resolve(&mut self, _includer: &str, name: &str) -> Result<Option<Resolved>, String> {
        let file = || Resolved { name: FILE.to_owned(), bytes: self.0.into() };
        Ok((name == FILE).then(file))
    }
}

/// Everything that is said about an example, lints included where it has no errors.
fn diagnostics(text: &str) -> Vec<Diagnostic> {
    let root = SourceFile { name: FILE.to_owned(), bytes: text.into(), builtin: false };
    let assembly = assemble(root, None, &mut Itself(text));
    let has_errors = assembly.has_errors();
    let mut diagnostics = assembly.diagnostics;
    if !has_errors {
        diagnostics.extend(lint::lint(&assembly.program, &assembly.sources));
    }
    diagnostics
}

/// The programs in a text, the wrong one first.
fn examples(text: &'static str) -> Vec<&'static str> {
    let blocks = text.split("```tmcl\n").skip(1);
    blocks.map(|block| block.split("```").next().unwrap_or_default()).collect()
}

#[test]
fn every_wrong_example_is_wrong_and_every_right_one_is_right() {
    for code in Code::ALL {
        let [wrong, right] = examples(code.explanation())[..] else {
            panic!("{code} does not have two examples");
        };
        let found = diagnostics(wrong);
        assert!(found.iter().any(|it| it.code == *code), "{code} is not found: {found:#?}\n{wrong}");
        let errors = found.iter().filter(|it| it.code.id().starts_with('E'));
        assert!(errors.clone().all(|it| it.code == *code), "{code} has other errors: {found:#?}");
        let left: Vec<_> = diagnostics(right)
            .into_iter()
            .filter(|it| it.code == *code || it.code.is_on_by_default())
            .collect();
        assert!(left.is_empty(), "{code}, corrected: {left:#?}\n{right}");
    }
}

#[test]
fn every_text_begins_with_a_sentence_and_says_why() {
    for code in Code::ALL {
        let text = code.explanation();
        let first = text.lines().next().unwrap_or_default();
        assert!(first.ends_with('.'), "{code}: {first}");
        let prose: String = text.split("```").step_by(2).collect();
        assert!(prose.split_whitespace().count() > 40, "{code} says little");
        let widest = text.lines().map(|line| line.chars().count()).max();
        assert!(widest <= Some(100), "{code} is {widest:?} characters wide");
    }
}

#[test]
fn no_text_names_a_code_that_does_not_exist() {
    for code in Code::ALL {
        let words = code.explanation().split(|character: char| !character.is_ascii_alphanumeric());
        let is_code = |word: &&str| {
            word.len() == 5
                && word.starts_with(['E', 'W'])
                && word[1..].bytes().all(|byte| byte.is_ascii_digit())
        };
        for named in words.filter(is_code) {
            assert!(named.parse::<Code>().is_ok(), "{code} names {named}");
        }
    }
}

#[test]
fn no_two_texts_are_the_same() {
    let mut texts: Vec<_> = Code::ALL.iter().map(|code| code.explanation()).collect();
    texts.sort_unstable();
    texts.dedup();
    assert_eq!(texts.len(), Code::ALL.len());
}

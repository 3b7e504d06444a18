//! Sessions of the command line: what is typed and what is printed stand in `tests/cmd/*.md` and the README.

#[test]
fn sessions() {
    trycmd::TestCases::new().case("tests/cmd/*.md").case("../../README.md");
}

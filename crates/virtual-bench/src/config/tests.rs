use super::*;
#[test]
fn probe() {
    for t in [
        "[[module]]\nkind='tmcm-1311'\n[module.motor]\nresistance_ohm=1\n[[event]]\nat=1\nset={ 'm1.load.x'=1, m1.load.y=2 }\n",
        "module.kind=1\n",
        "a = \nb = [\n[[module]\nkind==1\n",
    ] {
        for e in parse(t).unwrap_err() {
            println!("{}", e.report("b", t));
        }
    }
    let deep = "a.".repeat(100000) + "a=1";
    println!("{:?}", parse(&deep).map_err(|e| e.len()));
    let deep = "[".to_owned() + &"a.".repeat(100000) + "a]";
    println!("{:?}", parse(&deep).map_err(|e| e.len()));
    let deep = format!("a={}", "[".repeat(100000));
    println!("{:?}", parse(&deep).map_err(|e| e.len()));
}

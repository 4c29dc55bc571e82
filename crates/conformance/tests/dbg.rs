mod weights;
use std::time::Duration;
use conformance::*;
#[test]
fn dbg() {
    let Some(networks) = weights::published("x") else { return };
    let region = Region::scaled([("Q1", [-0.9375, 3.375]),("Q2", [-1.140625, 8.15625]),("X1", [-0.984375, 9.84375]),("X2", [-0.953125, 18.0])]).expect("r");
    let n = networks.iter().find(|n| n.output()=="Q2").expect("n");
    for nodes in [100,1000,10000,20000,50000,100000,1000000] {
        for p in paper_properties().into_iter().filter(|p| p.network=="Q2" && p.input=="Q2") {
            let l = Limits{relative_gap:1e-9,nodes,time:Duration::from_secs(100),cross_check:CrossCheck::None};
            let r = verify(n,&p,&region,&l,&||Duration::ZERO).expect("r");
            println!("{nodes} {:?} {} {} {:?} {:?}", r.property, r.m_lower, r.m_upper, r.verdict, r.witness);
        }
    }
}

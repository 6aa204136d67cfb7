//! Probe.
use tsutsumi_testkit::body::*; use tsutsumi_testkit::reading::*; use tsutsumi_testkit::noise::Noise; use tsutsumi::velocity::*; use std::cell::RefCell;
fn growth<const D: usize>(body: Body<D>, dt: f64, steps: usize) -> f64 {
  let n = RefCell::new(Noise::new(5));
  let mut s=body.velocity(move |_| n.borrow_mut().vector()*1e-9).build(); let v0=largest_speed(s.particles());
  for _ in 0..steps { if s.step(dt).is_err() { return f64::INFINITY; } }
  largest_speed(s.particles())/v0
}
fn scan<const D: usize>(name:&str, make: impl Fn()->Body<D>, steps: usize, fs: &[f64]) {
  let l=make().build().step_limits(); 
  for &f in fs { eprintln!("P {name} D{D} limit {:.5} {:?} f {f} dt {:.5} growth {:e}", l.longest(), l.governing, f*l.longest(), growth(make(), f*l.longest(), steps)); }
}
#[test] fn p() { 
 for m2 in [false,true] {
 fn up<const D: usize>(b: Body<D>, m2: bool)->Body<D> { if m2 {b.velocity_update(Mpm2)} else {b} }
 scan::<1>(&format!("wet {m2}"), || up(Body::<1>::column(10.0,1.0).drained(top::<1>()),m2), 2000, &[0.95,1.0,1.02,1.1,1.2]);
 scan::<2>(&format!("wet {m2}"), || up(Body::<2>::column(10.0,1.0).drained(top::<2>()),m2), 2000, &[0.9,1.0,1.2,1.35,1.37,1.5,1.6487,2.0]);
 scan::<3>(&format!("wet {m2}"), || up(Body::<3>::column(10.0,1.0).drained(top::<3>()),m2), 2000, &[0.9,1.0,1.2,1.3,1.4,1.5,1.6,2.0]);
 scan::<2>(&format!("wetwide {m2}"), || up(Body::<2>::layer(4.0,1.0,4).drained(top::<2>()),m2), 2000, &[0.9,1.0,1.2,1.37,1.5,1.65,2.0]);
 scan::<3>(&format!("wetwide {m2}"), || up(Body::<3>::layer(3.0,1.0,3).drained(top::<3>()),m2), 1000, &[0.9,1.0,1.2,1.37,1.5,1.65,2.0]);
 scan::<1>(&format!("dry {m2}"), || up(Body::<1>::column(10.0,1.0).dry(),m2), 3000, &[0.9,1.0,1.1,1.3,1.6]);
 scan::<2>(&format!("dry {m2}"), || up(Body::<2>::layer(4.0,1.0,4).dry(),m2), 3000, &[0.9,1.0,1.1,1.3,1.6]);
 scan::<3>(&format!("dry {m2}"), || up(Body::<3>::layer(3.0,1.0,3).dry(),m2), 1000, &[0.9,1.0,1.1,1.3,1.6]);
 }
 // consolidation-governed in 2-D? k large
}

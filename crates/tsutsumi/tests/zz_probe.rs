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

fn up<const D: usize>(b: Body<D>, m2: bool)->Body<D> { if m2 {b.velocity_update(Mpm2)} else {b} }
fn bis<const D: usize>(name:&str, make: impl Fn()->Body<D>, steps: usize) {
  let l=make().build().step_limits(); let (mut lo,mut hi)=(0.1,3.0);
  for _ in 0..9 { let f=0.5*(lo+hi); if growth(make(), f*l.longest(), steps)<3.0 {lo=f} else {hi=f} }
  eprintln!("P {name} D{D} limit {:.5} {:?} factor {lo:.3}", l.longest(), l.governing);
}
#[test] fn p() { 
 for m2 in [false,true] {
 for n in [1,2,3,4,8] { bis::<1>(&format!("dry m2 {m2} ppc {n}"), || up(Body::<1>::column(10.0,1.0).dry().particles_per_cell([n]),m2), 3000); }
 for n in [1,2,4] { bis::<2>(&format!("dry m2 {m2} ppc {n}"), || up(Body::<2>::layer(4.0,1.0,4).dry().particles_per_cell([n;2]),m2), 2000); }
 for n in [1,2,3] { bis::<3>(&format!("dry m2 {m2} ppc {n}"), || up(Body::<3>::layer(3.0,1.0,3).dry().particles_per_cell([n;3]),m2), 600); }
 for n in [1,2,4] { bis::<2>(&format!("wet m2 {m2} ppc {n}"), || up(Body::<2>::layer(4.0,1.0,4).drained(top::<2>()).particles_per_cell([n;2]),m2), 2000); }
 for n in [1,2,3] { bis::<3>(&format!("wet m2 {m2} ppc {n}"), || up(Body::<3>::layer(3.0,1.0,3).drained(top::<3>()).particles_per_cell([n;3]),m2), 600); }
 for k in [1e-4,1e-3,1e-2,1e-1,1.0] { for n in [2,4] { 
   bis::<1>(&format!("wet k {k} m2 {m2} ppc {n}"), || up(Body::<1>::column(10.0,1.0).drained(top::<1>()).conductivity(move |_| k).particles_per_cell([n]),m2), 3000);
   bis::<2>(&format!("wet k {k} m2 {m2} ppc {n}"), || up(Body::<2>::column(5.0,1.0).drained(top::<2>()).conductivity(move |_| k).particles_per_cell([n;2]),m2), 2000);
 } }
 }
}

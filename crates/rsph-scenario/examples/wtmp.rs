//! x
use rsph_core::shape::*; use rsph_core::sample::*; use std::time::Instant;
fn main(){
 let m=rsph_scenario::mesh_io::read_mesh(std::path::Path::new(&std::env::args().nth(1).unwrap()),1.0).unwrap();
 let t=Instant::now(); match MeshShape::new(&m,"mesh") {Err(e)=>println!("{e}"),Ok((s,n))=>{println!("{:?}",t.elapsed());
 for n in n {println!("- {n}");} println!("{:?} {:?}",s.repair(),(s.surface().genus(),s.surface().components(),s.surface().triangles.len()));
 for n in [1000,5000,20000,1000000]{ let t=Instant::now(); if let Ok(b)=sample(&s,Resolution::Particles(n),&[]){println!("{} {} dropped {} comps {} genus {:?} {:?}",b.cells.len(),b.volume(),b.dropped_volume,b.surface.components(),b.surface.genus(),t.elapsed());}}
 }}
}

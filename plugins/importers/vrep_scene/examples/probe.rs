use tatu_importers_vrep_scene::read::{file::*, surface::leaves};
fn main() {
    for f in std::env::args().skip(1) {
        let b = std::fs::read(&f).unwrap();
        let t = std::time::Instant::now();
        match File::read(&b) {
            Err(e) => println!("{f}: {e}"),
            Ok(x) => {
                let t1 = t.elapsed();
                let mut n = 0; let mut err = 0;
                for o in &x.objects { if let Kind::Shape(s) = &o.kind { for l in s.root.as_ref().map(leaves).unwrap_or_default() { match x.surface(l.leaf, s.shared.as_ref(), o.section.at) { Ok(s) => n += s.triangles.len(), Err(e) => { err += 1; println!("{e}") } } } } }
                println!("{f}: {} objects {} scripts {n} tris {err} errs, decode {:?} meshes {:?} {:.1} MB unpacked, step {:?} phys {} unknown {:?}", x.objects.len(), x.scripts.len(), t1, t.elapsed()-t1, x.data.len() as f64/1e6, x.settings.step(), x.settings.physics_step(), x.unknown.all.iter().map(|(k,v)| (k.clone(), v.count)).collect::<Vec<_>>());
            }
        }
    }
}

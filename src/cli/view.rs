// SPDX-License-Identifier: MIT OR Apache-2.0
//! `brdf-baker view`

use std::path::PathBuf;
use std::time::Instant;

use brdf_baker::bake::{Backend, Model};
use brdf_baker::progress::Progress;
use brdf_baker::texture::Meta;
use brdf_baker::view::{Origin, View};
use brdf_baker::{Error, Result};
use serde_json::json;

use super::Global;
use super::console::Console;
use super::lit::{self, Lit};

#[derive(clap::Args)]
pub struct ViewArgs {
    /// Environments, irradiance maps and tables, in any order: told apart by what they hold [default: the built-in sky
    /// with its sun, and a table that is baked]
    #[arg(value_name = "FILE")]
    files: Vec<PathBuf>,
    /// Page to write
    #[arg(short, long, value_name = "FILE.html", default_value = "view.html")]
    output: PathBuf,
    /// Open the page in the browser
    #[arg(long)]
    open: bool,
    /// Distribution of normals, for what is baked
    #[arg(long, default_value = "ggx", value_name = "NAME[:PARAMETER=VALUE,...]")]
    ndf: String,
    /// Geometry term, for the table that is baked
    #[arg(long, default_value = "smith", value_name = "NAME")]
    visibility: String,
}

impl ViewArgs {
    pub fn run(self, global: &Global, console: &mut Console) -> Result<()> {
        let start = Instant::now();

        // Everything that can be refused is refused before any work.
        let model = Model::parse(&self.ndf, &self.visibility)?;
        if model.is_anisotropic() {
            let what = "the spheres are shaded with round lobes, not with an anisotropic distribution";
            return Err(Error::usage(what, "leave ratio and azimuth out of --ndf"));
        }
        let output = super::verify::prepare_page(&self.output)?;
        let read = |path: &PathBuf, console: &mut Console| Ok((path.clone(), lit::read(path, console)?));
        let found: Vec<(PathBuf, Lit)> = self.files.iter().map(|path| read(path, console)).collect::<Result<_>>()?;

        let backend = Backend::open(&global.device, global.validate)?;
        let on = &mut |p: Progress<'_>| console.progress(p);
        let mut view = View::default();
        for (path, lit) in found {
            let origin = |flag: &str, facts: Meta| Origin {
                name: path.file_name().map_or(path.as_os_str(), |name| name).to_string_lossy().into_owned(),
                words: vec![flag.into(), path.display().to_string()],
                facts,
            };
            let named = |e: Error| match e {
                Error::Cancelled => e,
                e => Error::input(&path, e.to_string(), e.help().to_string()),
            };
            match lit {
                Lit::Filtered(cube) => {
                    view.add_filtered(origin("--env", cube.meta.clone()), cube, &backend, on).map_err(named)?;
                }
                Lit::Environment(environment) => {
                    view.add_environment(origin("--env", Meta::default()), &environment, &model, &backend, on)?;
                }
                Lit::Diffuse(cube) => view.add_diffuse(origin("--irradiance", cube.meta.clone()), cube),
                Lit::Table(lut, facts) => view.add_table(origin("--lut", facts), lut),
            }
        }
        let built_in = |name: &str, words: &[&str]| Origin {
            name: name.into(),
            words: words.iter().map(|word| word.to_string()).collect(),
            facts: Meta::default(),
        };
        if view.counts()[0] == 0 {
            view.add_environment(built_in("built-in sky", &[]), &lit::sky()?, &model, &backend, on)?;
        }
        view.add_white_room(built_in("white room", &["--furnace"]), &lit::white_room(), &model, &backend, on)?;
        if view.counts()[2] == 0 {
            let name = format!("baked: {}, {}", model.ndf, model.visibility.name);
            view.add_baked_table(built_in(&name, &[]), &model, &backend, on)?;
        }
        backend.check_messages()?;

        let mut words = vec![];
        for (flag, said, usual) in [("--ndf", &self.ndf, "ggx"), ("--visibility", &self.visibility, "smith")] {
            if said != usual {
                words.extend([flag.to_string(), said.clone()]);
            }
        }
        let page = view.page("Spheres under baked light", &words)?;
        let bytes = output.commit_bytes(page.as_bytes())?;

        let seconds = start.elapsed().as_secs_f64();
        let [lights, diffuses, tables] = view.counts();
        console.result(
            &format!(
                "{}  {:.1} MB, environments {lights}, irradiance maps {diffuses}, tables {tables}  {seconds:.2} s  {}",
                self.output.display(),
                bytes as f64 / 1e6,
                backend.name()
            ),
            &json!({
                "path": self.output,
                "bytes": bytes,
                "environments": lights,
                "irradiance_maps": diffuses,
                "tables": tables,
                "seconds": seconds,
                "device": backend.name(),
            }),
        )?;
        if self.open {
            let path = std::path::absolute(&self.output).map_err(|e| Error::io("find", &self.output, e))?;
            open::that_detached(&path).map_err(|e| {
                let what = format!("'{}' is written, but no browser opens it: {e}", self.output.display());
                Error::usage(what, "open the file by hand")
            })?;
        }
        Ok(())
    }
}

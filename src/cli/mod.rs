// SPDX-License-Identifier: MIT OR Apache-2.0
//! What the user may say, and which command answers.

mod bake;
pub mod console;
mod curves;
mod device;
mod env;
mod foreign;
mod given;
mod identify;
mod info;
mod list;
mod lit;
mod materials;
mod own;
mod preview;
mod run;
mod sky;
mod source;
mod storage;
mod verify;
mod verify_environment;
mod view;

use std::path::PathBuf;

use brdf_baker::Result;
use clap::{CommandFactory, Parser, Subcommand};

use console::Console;
use device::Device;

/// Bakes the lookup tables of physically based shading on the GPU, and proves every one right.
///
/// Results go to stdout, one line a file (or one JSON object a line with --json); progress and errors to stderr.
/// Exit codes: 0 done, 1 a check failed, 2 usage or failure, 130 cancelled.
#[derive(Parser)]
#[command(name = "brdf-baker", version, arg_required_else_help = true)]
pub struct Args {
    #[command(subcommand)]
    command: Command,
    #[command(flatten)]
    global: Global,
}

#[derive(clap::Args)]
pub struct Global {
    /// Where to compute: auto (a GPU, else software Vulkan, else the processor), cpu, or a device by index, UUID or name
    #[arg(
        long,
        global = true,
        default_value = "auto",
        value_name = "auto|cpu|INDEX|UUID|NAME",
        hide_default_value = true
    )]
    pub device: String,
    /// Run under the Vulkan validation layer; any message is a failure
    #[arg(long, global = true)]
    pub validate: bool,
    /// Print no progress and no warnings
    #[arg(long, short, global = true)]
    pub quiet: bool,
    /// Print results as JSON, one object a line
    #[arg(long, global = true)]
    pub json: bool,
}

#[derive(Subcommand)]
enum Command {
    /// Bake a lookup table
    #[command(after_help = "Examples:
  brdf-baker bake split-sum -o dfg.ktx2
  brdf-baker bake split-sum --for bevy
  brdf-baker bake average-albedo --of albedo.ktx2 -o average.ktx2
  brdf-baker bake ltc+ltc-magnitude -o ltc.ktx2
  brdf-baker bake albedo -o copper.exr --material copper --ndf ggx:ratio=0.3,azimuth=45
  brdf-baker bake split-sum -o mine.ktx2 --glsl my_brdf.glsl --min-roughness 0.045")]
    Bake(Box<given::Given<bake::BakeArgs>>),
    /// Prefilter an environment: specular mips, irradiance, spherical harmonics
    #[command(
        after_help = "INPUT is a file (.hdr .exr .png .jpg: equirectangular, strip or cross; .ktx2 .dds: a cube) \
or six faces: a folder, a path with {face} in it, or six paths joined by commas in the order +X,-X,+Y,-Y,+Z,-Z. Faces are \
called px nx py ny pz nz, posx negx ..., or right left top bottom front back.

Examples:
  brdf-baker env studio.exr -o studio.ktx2
  brdf-baker env studio.exr --for three
  brdf-baker env 'yard_{face}.png' -o yard.ktx2 --rotate 90 --exposure -1 --clamp 1000
  brdf-baker env sky.hdr -o sky.ktx2 --irradiance diffuse.ktx2 --sh sky.json
  brdf-baker env sky.hdr -o sheen.ktx2 --kernel charlie --shape octahedral
  brdf-baker env sky.hdr -o diffuse.hdr --kernel lambert --shape equirect"
    )]
    Env(Box<env::EnvArgs>),
    /// Bake everything that a recipe declares, and only what changed
    #[command(
        after_help = "A recipe is a TOML file; docs/farm.md has all its keys. Files state the hash of what they were \
baked from, and what is up to date is left alone, so that a run that was killed goes on where it ended.

Examples:
  brdf-baker run recipe.toml --dry-run
  brdf-baker run recipe.toml --json
  brdf-baker run recipe.toml --shard 2/8
  brdf-baker run recipe.toml --emit-openjd job.yaml
  brdf-baker run --schema > recipe.schema.json"
    )]
    Run(run::RunArgs),
    /// Write a clear daylight sky, after Preetham, as an environment: no download needed
    #[command(
        after_help = "Radiance is in kcd/m2: 0.2126 r + 0.7152 g + 0.0722 b is the luminance. +Y is up; the ground \
below reflects the light of sky and sun.

Examples:
  brdf-baker sky -o sky.exr
  brdf-baker sky -o evening.hdr --elevation 4 --turbidity 5 --sun-disc --exposure -5"
    )]
    Sky(sky::SkyArgs),
    /// Plot D, G, F and whole lobes against the angle, or a table in false colour, as SVG or PNG
    #[command(after_help = "A curve is said in words, in any order: a distribution with its parameters (ggx, \
blinn-phong:exponent=10.67), its width (alpha=0.3 or roughness=0.5), a geometry term (smith, cook-torrance), and a \
material, ior=1.5 or f0=0.04. What is left out is ggx, roughness=0.5, smith, F = 1.

Examples:
  brdf-baker curves -o fresnel.svg --plot f
  brdf-baker curves -o lobes.png --curve 'beckmann alpha=0.748 schlick-beckmann' \
--curve 'blinn-phong:exponent=10.67 schlick-beckmann'
  brdf-baker curves -o copper.svg --plot polar --view 60 --curve 'roughness=0.4 copper'
  brdf-baker curves dfg.ktx2 -o table.png")]
    Curves(curves::CurvesArgs),
    /// Draw spheres lit by baked maps, by an integral of the same BRDF, or both and their difference
    #[command(
        after_help = "Metallic and roughness run over a grid of spheres; the camera looks along -Z, +Y is up. Without \
--env they stand under the built-in sky. --env takes what `brdf-baker env` takes, or a cube that it wrote.

Examples:
  brdf-baker preview -o spheres.png
  brdf-baker preview -o copper.png --env studio.exr --material copper --compare --size 500x500
  brdf-baker preview -o mine.png --env studio.ktx2 --lut dfg.ktx2 --compensate
  brdf-baker preview -o brick.png --spheres 1x1 --base-color brick.png --normal brick_n.png --roughness 0.6"
    )]
    Preview(Box<preview::PreviewArgs>),
    /// Write one page of HTML with the spheres to turn and to change, lit by baked files, in WebGL 2
    #[command(
        after_help = "What a file holds is told by its content: environments (pictures or filtered cubes), irradiance \
maps and split-sum tables, ours or others'. The page needs no network and no other file; it shows the command of `brdf-baker \
preview` that draws the same.

Examples:
  brdf-baker view --open
  brdf-baker view studio.ktx2 dfg.ktx2 -o studio.html
  brdf-baker view studio.exr evening.ktx2 diffuse.ktx2 dfg.ktx2 brdf_lut.png --open"
    )]
    View(view::ViewArgs),
    /// Check a baked file, or a table that others made, against an independent f64 integration; exit code 1 if it is wrong
    #[command(after_help = "Examples:
  brdf-baker verify dfg.ktx2
  brdf-baker verify dfg.ktx2 --full --json
  brdf-baker verify mine.ktx2 --glsl my_brdf.glsl")]
    Verify(verify::VerifyArgs),
    /// Say what a table of unknown origin is: model, channels, axes, encoding; exit code 1 if nothing fits
    #[command(after_help = "Examples:
  brdf-baker identify brdf_lut.png
  brdf-baker identify dfg.bin --size 64 --encoding rg16f --json")]
    Identify(identify::IdentifyArgs),
    /// Print what a baked file is: model, axes, channels, conventions, measured error
    #[command(after_help = "Examples:
  brdf-baker info dfg.ktx2
  brdf-baker info studio.ktx2 --json")]
    Info {
        /// A file that brdf-baker wrote
        file: PathBuf,
    },
    /// List the Vulkan devices that can compute
    #[command(after_help = "Examples:
  brdf-baker devices
  brdf-baker devices --json")]
    Devices,
    /// List what can be chosen: tables, distributions, visibility and Fresnel terms, kernels, roughness laws, encodings, formats, targets
    #[command(after_help = "Examples:
  brdf-baker list targets
  brdf-baker list encodings --json")]
    List {
        /// Only this registry
        #[arg(value_enum)]
        what: Option<list::What>,
    },
    /// Print named metals and dielectrics: index, reflectance as linear sRGB, source
    #[command(after_help = "Examples:
  brdf-baker materials copper
  brdf-baker materials --json")]
    Materials {
        /// Only this one
        name: Option<String>,
    },
    /// Write shell completions to stdout
    #[command(after_help = "Examples:
  brdf-baker completions bash > ~/.local/share/bash-completion/completions/brdf-baker
  brdf-baker completions zsh > ~/.zfunc/_brdf-baker")]
    Completions {
        /// The shell to write for
        shell: clap_complete::Shell,
    },
}

/// Carries out a command.
pub fn run(args: Args) -> Result<()> {
    let mut console = Console::new(&args.global)?;
    match args.command {
        Command::Bake(bake) => bake::run(*bake, &Device::new(&args.global), &mut console),
        Command::Env(env) => env.run(&Device::new(&args.global), &mut console),
        Command::Run(run) => run.run(&args.global, &mut console),
        Command::Sky(sky) => sky.run(&mut console),
        Command::Curves(curves) => curves.run(&mut console),
        Command::Preview(preview) => preview.run(&args.global, &mut console),
        Command::View(view) => view.run(&args.global, &mut console),
        Command::Verify(verify) => verify.run(&args.global, &mut console),
        Command::Identify(identify) => identify.run(&mut console),
        Command::Info { file } => info::run(&file, &mut console),
        Command::Devices => list::devices(&mut console),
        Command::List { what } => list::run(what, &mut console),
        Command::Materials { name } => materials::run(name.as_deref(), &mut console),
        Command::Completions { shell } => {
            let mut script = vec![];
            clap_complete::generate(shell, &mut Args::command(), "brdf-baker", &mut script);
            console.raw(&script)
        }
    }
}

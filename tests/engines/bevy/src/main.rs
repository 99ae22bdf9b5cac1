// SPDX-License-Identifier: MIT OR Apache-2.0
//! Bevy without a window: the spheres with maps of brdf-baker, and with those that Bevy filters at run time.
//!
//! `bevy-spheres FOLDER JOB` reads the test's files in FOLDER and writes `bevy-JOB.f32` there. Jobs: `ours`, `table` (our
//! maps, Bevy's table), `own` (Bevy's maps and table), `lights`, which also writes `bevy-background.f32`.

use std::path::PathBuf;
use std::time::Duration;

use bevy::app::ScheduleRunnerPlugin;
use bevy::asset::{RenderAssetUsages, UnapprovedPathMode};
use bevy::camera::{Exposure, Hdr, RenderTarget, ScalingMode};
use bevy::core_pipeline::tonemapping::{DebandDither, Tonemapping};
use bevy::light::{GeneratedEnvironmentMapLight, GlobalAmbientLight, Skybox};
use bevy::pbr::DfgLut;
use bevy::prelude::*;
use bevy::render::gpu_readback::{Readback, ReadbackComplete};
use bevy::render::pipelined_rendering::PipelinedRenderingPlugin;
use bevy::render::render_resource::{TextureFormat, TextureUsages};
use bevy::render::{RenderApp, RenderPlugin};
use bevy::window::ExitCondition;
use serde_json::Value;

/// Frames between the arrival of the files and the picture: maps are filtered, pipelines are built.
const WARM_UP_FRAMES: u32 = 10;
/// Pixels along a side of a view of the background.
const LOOK_PX: u32 = 64;
/// Where the cameras of the background test look, and what is up.
const LOOKS: [[Vec3; 2]; 6] = [
    [Vec3::X, Vec3::Y],
    [Vec3::NEG_X, Vec3::Y],
    [Vec3::Y, Vec3::Z],
    [Vec3::NEG_Y, Vec3::NEG_Z],
    [Vec3::Z, Vec3::Y],
    [Vec3::NEG_Z, Vec3::Y],
];

/// What is drawn, and with which maps.
#[derive(Resource, Clone, Copy)]
struct Job {
    name: &'static str,
    scene: &'static str,
    environment: &'static str,
    /// The table of brdf-baker instead of Bevy's.
    table: bool,
    /// Bevy filters mip 0 itself.
    generated: bool,
    /// Also look at what lies behind the scene.
    background: bool,
}

const OURS: Job = Job {
    name: "ours",
    scene: "spheres.json",
    environment: "bevy-sky",
    table: true,
    generated: false,
    background: false,
};

const JOBS: [Job; 4] = [
    OURS,
    Job { name: "table", table: false, ..OURS },
    Job { name: "own", table: false, generated: true, ..OURS },
    Job { name: "lights", scene: "lights.json", environment: "bevy-lights", background: true, ..OURS },
];

#[derive(Resource)]
struct Folder(PathBuf);

/// Files that must have arrived.
#[derive(Resource, Default)]
struct Files(Vec<UntypedHandle>);

/// A camera's picture: where it belongs in the result, its target, and its texels once they have been read back.
struct Shot {
    target: Handle<Image>,
    texels: Option<Vec<u8>>,
}

#[derive(Resource, Default)]
struct Shots(Vec<Shot>);

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [folder, name] = arguments.as_slice() else {
        eprintln!("usage: bevy-spheres FOLDER JOB");
        std::process::exit(2);
    };
    let job = *JOBS.iter().find(|job| job.name == name).expect("a job of the list");
    let folder = PathBuf::from(folder).canonicalize().expect("the folder exists");

    let mut app = App::new();
    app.add_plugins(
        DefaultPlugins
            .set(WindowPlugin { primary_window: None, exit_condition: ExitCondition::DontExit, ..default() })
            .set(RenderPlugin { synchronous_pipeline_compilation: true, ..default() })
            .set(AssetPlugin {
                file_path: folder.display().to_string(),
                unapproved_path_mode: UnapprovedPathMode::Forbid,
                ..default()
            })
            .disable::<PipelinedRenderingPlugin>(),
    );
    app.add_plugins(ScheduleRunnerPlugin::run_loop(Duration::ZERO));
    app.insert_resource(GlobalAmbientLight::NONE);
    app.insert_resource(ClearColor(Color::BLACK));
    app.insert_resource(job).insert_resource(Folder(folder));
    app.init_resource::<Files>().init_resource::<Shots>();

    if job.table {
        let table: Handle<Image> = app.world().resource::<AssetServer>().load("bevy-dfg.ktx2");
        app.world_mut().resource_mut::<Files>().0.push(table.clone().untyped());
        app.sub_app_mut(RenderApp).insert_resource(DfgLut { texture: table });
    }

    app.add_systems(Startup, set_up).add_systems(Update, (take, finish).chain());
    app.run();
}

fn set_up(
    mut commands: Commands,
    job: Res<Job>,
    folder: Res<Folder>,
    server: Res<AssetServer>,
    mut files: ResMut<Files>,
    mut shots: ResMut<Shots>,
    mut images: ResMut<Assets<Image>>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    let text = std::fs::read_to_string(folder.0.join(job.scene)).expect("the scene can be read");
    let scene: Value = serde_json::from_str(&text).expect("the scene is JSON");
    let number = |value: &Value| value.as_f64().expect("a number") as f32;

    let shape = Sphere::new(number(&scene["radius"])).mesh().uv(256, 128);
    let shape = meshes.add(shape);
    for sphere in scene["spheres"].as_array().expect("a list") {
        let (centre, colour) = (&sphere["centre"], &sphere["colour"]);
        let material = StandardMaterial {
            base_color: Color::linear_rgb(number(&colour[0]), number(&colour[1]), number(&colour[2])),
            metallic: number(&sphere["metallic"]),
            perceptual_roughness: number(&sphere["roughness"]),
            ..default()
        };
        commands.spawn((
            Mesh3d(shape.clone()),
            MeshMaterial3d(materials.add(material)),
            Transform::from_xyz(number(&centre[0]), number(&centre[1]), 0.0),
        ));
    }

    let mut load = |name: String| -> Handle<Image> {
        let handle = server.load(name);
        files.0.push(handle.clone().untyped());
        handle
    };
    let specular = load(format!("{}_specular.ktx2", job.environment));
    let diffuse = load(format!("{}_diffuse.ktx2", job.environment));

    let mut target = |width: u32, height: u32| {
        let mut image = Image::new_target_texture(width, height, TextureFormat::Rgba32Float, None);
        image.texture_descriptor.usage |= TextureUsages::COPY_SRC;
        image.asset_usage = RenderAssetUsages::all();
        let handle = images.add(image);
        shots.0.push(Shot { target: handle.clone(), texels: None });
        RenderTarget::Image(handle.into())
    };
    // What a camera needs so that a pixel holds the radiance itself: no exposure, no curve, no noise.
    let linear = || {
        (
            Camera3d::default(),
            Hdr,
            Msaa::Off,
            Tonemapping::None,
            DebandDither::Disabled,
            Exposure { ev100: -(1.2f32.log2()) },
        )
    };

    let tiles = &scene["tiles"];
    let projection = OrthographicProjection {
        scaling_mode: ScalingMode::Fixed { width: number(&tiles[0]), height: number(&tiles[1]) },
        near: 1.0,
        far: 20.0,
        ..OrthographicProjection::default_3d()
    };
    let pixels = [0, 1].map(|i| number(&scene["size_px"][i]) as u32);
    let mut camera = commands.spawn((
        linear(),
        target(pixels[0], pixels[1]),
        Projection::Orthographic(projection),
        Transform::from_xyz(0.0, 0.0, 10.0),
    ));
    if job.generated {
        camera.insert(GeneratedEnvironmentMapLight { environment_map: specular, intensity: 1.0, ..default() });
    } else {
        camera.insert(EnvironmentMapLight {
            diffuse_map: diffuse,
            specular_map: specular.clone(),
            intensity: 1.0,
            ..default()
        });
        for (i, [towards, up]) in LOOKS.into_iter().enumerate().filter(|_| job.background) {
            commands.spawn((
                linear(),
                Camera { order: 1 + i as isize, ..default() },
                target(LOOK_PX, LOOK_PX),
                // Far from the spheres.
                Transform::from_translation(100.0 * Vec3::Y).looking_to(towards, up),
                Skybox { image: Some(specular.clone()), brightness: 1.0, ..default() },
            ));
        }
    }
}

/// Asks for the pictures once everything has arrived.
fn take(
    mut commands: Commands,
    server: Res<AssetServer>,
    files: Res<Files>,
    shots: Res<Shots>,
    mut frames: Local<u32>,
) {
    for file in &files.0 {
        if let Some(bevy::asset::LoadState::Failed(error)) = server.get_load_state(file) {
            eprintln!("bevy: {error}");
            std::process::exit(1);
        }
    }
    if files.0.iter().all(|file| server.is_loaded_with_dependencies(file)) {
        *frames += 1;
    }
    if *frames != WARM_UP_FRAMES {
        return;
    }
    for (i, shot) in shots.0.iter().enumerate() {
        commands.spawn(Readback::texture(shot.target.clone())).observe(
            move |event: On<ReadbackComplete>, mut shots: ResMut<Shots>| {
                shots.0[i].texels = Some(event.data.clone());
            },
        );
    }
    *frames += 1;
}

/// Writes the pictures and ends.
fn finish(job: Res<Job>, folder: Res<Folder>, shots: Res<Shots>, mut exit: MessageWriter<AppExit>) {
    let texels: Option<Vec<&Vec<u8>>> = shots.0.iter().map(|shot| shot.texels.as_ref()).collect();
    let Some([picture, looks @ ..]) = texels.as_deref() else { return };
    let write = |name: &str, bytes: &[u8]| {
        std::fs::write(folder.0.join(format!("bevy-{name}.f32")), bytes).expect("the folder can be written to");
    };
    write(job.name, picture);
    if job.background {
        // Rows of a read texture begin at multiples of 256 bytes: those of LOOK_PX pixels do.
        let middle = (16 * (LOOK_PX / 2 * LOOK_PX + LOOK_PX / 2)) as usize;
        let middles: Vec<u8> = looks.iter().flat_map(|look| look[middle..middle + 16].to_vec()).collect();
        write("background", &middles);
    }
    exit.write(AppExit::Success);
}

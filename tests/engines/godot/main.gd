# SPDX-License-Identifier: MIT OR Apache-2.0
# The layout's spheres under a panorama, and what lies behind them, with the engine's sky material and with a shader that the
# compatibility renderer shows as it is; pictures go to the page, in 8 bits.
extends Node3D

var view := SubViewport.new()
var camera := Camera3D.new()

func _ready() -> void:
	var layout: Dictionary = JSON.parse_string(FileAccess.get_file_as_string("res://layout.json"))

	var panorama := ImageTexture.create_from_image(Image.load_from_file("res://studio_equirect.hdr"))
	var material := PanoramaSkyMaterial.new()
	material.panorama = panorama
	var own := ShaderMaterial.new()
	own.shader = load("res://sky.gdshader")
	own.set_shader_parameter("panorama", panorama)
	var environment := Environment.new()
	environment.sky = Sky.new()
	environment.background_mode = Environment.BG_SKY
	environment.ambient_light_source = Environment.AMBIENT_SOURCE_SKY
	environment.reflected_light_source = Environment.REFLECTION_SOURCE_SKY
	camera.environment = environment

	view.own_world_3d = true
	view.render_target_update_mode = SubViewport.UPDATE_ALWAYS
	view.add_child(camera)
	add_child(view)

	var spheres := Node3D.new()
	for sphere: Dictionary in layout.spheres:
		var mesh := SphereMesh.new()
		mesh.radius = layout.radius
		mesh.height = 2.0 * layout.radius
		mesh.radial_segments = 256
		mesh.rings = 128
		var surface := StandardMaterial3D.new()
		# Colours of materials are sRGB.
		surface.albedo_color = Color(sphere.colour[0], sphere.colour[1], sphere.colour[2]).linear_to_srgb()
		surface.metallic = sphere.metallic
		surface.roughness = sphere.roughness
		mesh.material = surface
		var instance := MeshInstance3D.new()
		instance.mesh = mesh
		instance.position = Vector3(sphere.centre[0], sphere.centre[1], 0.0)
		spheres.add_child(instance)
	view.add_child(spheres)

	for sky: Array in [["material", material], ["shader", own]]:
		environment.sky.sky_material = sky[1]
		spheres.show()
		camera.set_orthogonal(layout.tiles[1], 1.0, 20.0)
		camera.transform = Transform3D(Basis.IDENTITY, Vector3(0.0, 0.0, 10.0))
		await picture("%s-lights" % sky[0], layout.size_px[0], layout.size_px[1])

		spheres.hide()
		camera.position = Vector3.ZERO
		camera.set_perspective(60.0, 0.1, 100.0)
		for i: int in layout.looks.size():
			var look: Array = layout.looks[i]
			camera.look_at(vector(look[0]), vector(look[1]))
			await picture("%s-%d" % [sky[0], i], 16, 16)
	JavaScriptBridge.eval("godot.done()")

func vector(components: Array) -> Vector3:
	return Vector3(components[0], components[1], components[2])

func picture(name_: String, width: int, height: int) -> void:
	view.size = Vector2i(width, height)
	# The sky is filtered over several frames.
	for frame: int in 12:
		await RenderingServer.frame_post_draw
	var image := view.get_texture().get_image()
	image.convert(Image.FORMAT_RGBA8)
	JavaScriptBridge.eval("godot.picture('%s', '%s')" % [name_, Marshalls.raw_to_base64(image.get_data())])

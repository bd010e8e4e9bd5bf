//! Constants of the API: `sim_handle_self` and `sim.handle_self`.
//!
//! A single table lists the constants by subject, without a prefix. Each constant is registered with both prefixes; the
//! flat name of `rml_x` is `simrml_x`. The meaning of a value is documented at the command that uses it.

use crate::kit::*;

pub(crate) fn offer(offer: &mut Offer<Vrep>) {
    for (name, value) in all() {
        let flat = match name.strip_prefix("rml_") {
            Some(rest) => format!("simrml_{rest}"),
            None => format!("sim_{name}"),
        };
        offer.constant(Constant::new(flat, value));
        offer.constant(Constant::new(format!("sim.{name}"), value));
    }
}

/// Returns the names and values in `TABLE`.
fn all() -> impl Iterator<Item = (&'static str, i64)> {
    TABLE.lines().filter(|line| !line.starts_with('#')).flat_map(|line| line.split(';')).filter_map(|item| {
        let (name, value) = item.trim().split_once(' ')?;
        let value = match value.strip_prefix("0x") {
            Some(hex) => i64::from_str_radix(hex, 16),
            None => value.parse(),
        };
        Some((name, value.ok()?))
    })
}

const TABLE: &str = "\
# Lifecycle: as in V-REP 3.1.3 to 3.4 for child scripts, whose authors often wrote the numbers instead of the names
mainscriptcall_initialization 0; mainscriptcall_cleanup 1; mainscriptcall_regular 2
childscriptcall_initialization 0; childscriptcall_cleanup 1; childscriptcall_actuation 2; childscriptcall_sensing 3
childscriptcall_threaded 4
customizationscriptcall_initialization 0; customizationscriptcall_cleanup 1; customizationscriptcall_first 0
customizationscriptcall_last 1; customizationscriptcall_simulationactuation 2
customizationscriptcall_simulationsensing 3; customizationscriptcall_firstaftersimulation 4
customizationscriptcall_nonsimulation 5; customizationscriptcall_lastbeforesimulation 6
customizationscriptcall_simulationpause 7; customizationscriptcall_simulationpausefirst 8
customizationscriptcall_simulationpauselast 9; customizationscriptcall_lastbeforeinstanceswitch 10
customizationscriptcall_firstafterinstanceswitch 11; customizationscriptcall_beforecopy 12
customizationscriptcall_aftercopy 13
addonscriptcall_initialization 0; addonscriptcall_cleanup 1; addonscriptcall_run 14; addonscriptcall_suspend 15
addonscriptcall_restarting 16
# System callbacks: the same numbers, so that old scripts can compare sim_call_type with them
syscb_init 0; syscb_cleanup 1; syscb_regular 2; syscb_actuation 2; syscb_sensing 3; syscb_aftersimulation 4
syscb_nonsimulation 5; syscb_beforesimulation 6; syscb_suspended 7; syscb_suspend 8; syscb_resume 9
syscb_beforeinstanceswitch 10; syscb_afterinstanceswitch 11; syscb_beforecopy 12; syscb_aftercopy 13
syscb_run 14; syscb_aos_run 14; syscb_aos_suspend 15; syscb_aos_resume 16; syscb_jointcallback 17
syscb_contactcallback 18; syscb_customcallback1 19; syscb_customcallback2 20; syscb_customcallback3 21
syscb_customcallback4 22; syscb_beforedelete 23; syscb_afterdelete 24; syscb_aftercreate 25; syscb_threadmain 26
syscb_info 27; syscb_dyncallback 28; syscb_beforemainscript 29; syscb_vision 30; syscb_trigger 31
syscb_userconfig 32; syscb_moduleentry 33; syscb_event 34; syscb_ext 35; syscb_realtimeidle 36; syscb_beforesave 37
syscb_aftersave 38; syscb_msg 39; syscb_dyn 40; syscb_contact 41; syscb_joint 42; syscb_thread 43
syscb_selchange 44; syscb_data 45
# Scene object types
object_shape_type 0; object_joint_type 1; object_graph_type 2; object_camera_type 3; object_dummy_type 4
object_proximitysensor_type 5; object_path_type 8; object_visionsensor_type 9; object_mill_type 11
object_forcesensor_type 12; object_light_type 13; object_mirror_type 14; object_octree_type 15
object_pointcloud_type 16
# General object types
appobj_object_type 109; appobj_collision_type 110; appobj_distance_type 111; appobj_simulation_type 112
appobj_ik_type 113; appobj_constraintsolver_type 114; appobj_collection_type 115; appobj_ui_type 116
appobj_script_type 117; appobj_pathplanning_type 118; appobj_texture_type 120; appobj_motionplanning_type 121
# IK methods
ik_pseudo_inverse_method 0; ik_damped_least_squares_method 1; ik_jacobian_transpose_method 2
# IK constraints
ik_x_constraint 1; ik_y_constraint 2; ik_z_constraint 4; ik_alpha_beta_constraint 8; ik_gamma_constraint 16
ik_avoidance_constraint 64
# IK results
ikresult_not_performed 0; ikresult_success 1; ikresult_fail 2
# Sub-types
light_omnidirectional_subtype 1; light_spot_subtype 2; light_directional_subtype 3; joint_revolute_subtype 10
joint_prismatic_subtype 11; joint_spherical_subtype 12; shape_simpleshape_subtype 20
shape_multishape_subtype 21; proximitysensor_pyramid_subtype 30; proximitysensor_cylinder_subtype 31
proximitysensor_disc_subtype 32; proximitysensor_cone_subtype 33; proximitysensor_ray_subtype 34
mill_pyramid_subtype 40; mill_cylinder_subtype 41; mill_disc_subtype 42; mill_cone_subtype 43
object_no_subtype 200
# Object special properties
objectspecialproperty_collidable 1; objectspecialproperty_measurable 2
objectspecialproperty_detectable_ultrasonic 16; objectspecialproperty_detectable_infrared 32
objectspecialproperty_detectable_laser 64; objectspecialproperty_detectable_inductive 128
objectspecialproperty_detectable_capacitive 256; objectspecialproperty_renderable 512
objectspecialproperty_detectable_all 496; objectspecialproperty_cuttable 1024
objectspecialproperty_pathplanning_ignored 2048
# Model properties
modelproperty_not_collidable 1; modelproperty_not_measurable 2; modelproperty_not_renderable 4
modelproperty_not_detectable 8; modelproperty_not_cuttable 16; modelproperty_not_dynamic 32
modelproperty_not_respondable 64; modelproperty_not_reset 128; modelproperty_not_visible 256
modelproperty_scripts_inactive 512; modelproperty_not_showasinsidemodel 1024; modelproperty_not_model 61440
# Messages
message_ui_button_state_change 0; message_object_selection_changed 2; message_model_loaded 4; message_keypress 6
message_bannerclicked 7; message_scene_loaded 8; message_prox_sensor_select_down 9
message_prox_sensor_select_up 10; message_pick_select_down 11; message_eventcallback_scenesave 260
message_eventcallback_modelsave 261; message_eventcallback_moduleopen 262
message_eventcallback_modulehandle 263; message_eventcallback_moduleclose 264
message_eventcallback_instancepass 269; message_eventcallback_broadcast 270
message_eventcallback_imagefilter_enumreset 271; message_eventcallback_imagefilter_enumerate 272
message_eventcallback_imagefilter_adjustparams 273; message_eventcallback_imagefilter_process 275
message_eventcallback_abouttoundo 280; message_eventcallback_undoperformed 281
message_eventcallback_abouttoredo 282; message_eventcallback_redoperformed 283
message_eventcallback_scripticondblclick 284; message_eventcallback_simulationabouttostart 285
message_eventcallback_simulationended 286; message_eventcallback_keypress 288
message_eventcallback_modulehandleinsensingpart 289; message_eventcallback_renderingpass 290
message_eventcallback_bannerclicked 291; message_eventcallback_menuitemselected 292
message_eventcallback_refreshdialogs 293; message_eventcallback_sceneloaded 294
message_eventcallback_modelloaded 295; message_eventcallback_instanceswitch 296
message_eventcallback_guipass 297; message_eventcallback_mainscriptabouttobecalled 298
message_eventcallback_rmlposition 299; message_eventcallback_rmlvelocity 300
message_eventcallback_pathplanningplugin 303; message_eventcallback_colladaplugin 304
message_eventcallback_opengl 305; message_eventcallback_openglframe 306
message_eventcallback_openglcameraview 307; message_eventcallback_proxsensorselectdown 308
message_eventcallback_proxsensorselectup 309; message_eventcallback_pickselectdown 310
message_eventcallback_rmlpos 311; message_eventcallback_rmlvel 312; message_eventcallback_rmlstep 313
message_eventcallback_rmlremove 314; message_eventcallback_rmlinfo 315
message_eventcallback_beforerendering 316; message_eventcallback_extrenderer_light 318
message_eventcallback_extrenderer_mesh 319; message_eventcallback_extrenderer_stop 320
message_eventcallback_extrenderer_triangles 333; message_eventcallback_simulationabouttoend 334
message_eventcallback_instanceabouttoswitch 335; message_simulation_start_resume_request 4096
message_simulation_pause_request 4097; message_simulation_stop_request 4098
# Object properties
objectproperty_collapsed 16; objectproperty_selectable 32; objectproperty_selectmodelbaseinstead 128
objectproperty_dontshowasinsidemodel 256; objectproperty_canupdatedna 1024; objectproperty_selectinvisible 2048
objectproperty_depthinvisible 4096; objectproperty_cannotdelete 8192; objectproperty_cannotdeleteduringsim 16384
# Old plugin argument types
lua_arg_nil 0; lua_arg_bool 1; lua_arg_int 2; lua_arg_float 3; lua_arg_string 4; lua_arg_invalid 5
lua_arg_charbuff 6; lua_arg_double 7; lua_arg_table 8
# Script argument types
script_arg_null 0; script_arg_bool 1; script_arg_int32 2; script_arg_float 3; script_arg_string 4
script_arg_invalid 5; script_arg_charbuff 6; script_arg_double 7; script_arg_table 8
# Old UI menu attributes
ui_menu_title 1; ui_menu_minimize 2; ui_menu_close 4; ui_menu_systemblock 8
# Old UI properties
ui_property_visible 1; ui_property_visibleduringsimulationonly 2; ui_property_moveable 4
ui_property_relativetoleftborder 8; ui_property_relativetotopborder 16; ui_property_fixedwidthfont 32
ui_property_systemblock 64; ui_property_settocenter 128; ui_property_rolledup 256
ui_property_selectassociatedobject 512; ui_property_visiblewhenobjectselected 1024
ui_property_systemblockcanmovetofront 2048; ui_property_pauseactive 4096
# Old UI button properties
buttonproperty_button 0; buttonproperty_label 1; buttonproperty_slider 2; buttonproperty_editbox 3
buttonproperty_staydown 8; buttonproperty_enabled 16; buttonproperty_borderless 32
buttonproperty_horizontallycentered 64; buttonproperty_ignoremouse 128; buttonproperty_isdown 256
buttonproperty_transparent 512; buttonproperty_nobackgroundcolor 1024; buttonproperty_rollupaction 2048
buttonproperty_closeaction 4096; buttonproperty_verticallycentered 8192; buttonproperty_downupevent 16384
# Simulation states
simulation_stopped 0; simulation_paused 8; simulation_advancing 16; simulation_advancing_firstafterstop 16
simulation_advancing_running 17; simulation_advancing_lastbeforepause 19
simulation_advancing_firstafterpause 20; simulation_advancing_abouttostop 21
simulation_advancing_lastbeforestop 22
# Script execution results
script_no_error 0; script_main_script_nonexistent 1; script_main_script_not_called 2; script_reentrance_error 4
script_lua_error 8; script_call_error 16
# Script types
scripttype_mainscript 0; scripttype_childscript 1; scripttype_addonscript 2; scripttype_addonfunction 3
scripttype_jointctrlcallback 4; scripttype_contactcallback 5; scripttype_customizationscript 6
scripttype_generalcallback 7; scripttype_sandboxscript 8; scripttype_threaded 240
# Script attributes
customizationscriptattribute_activeduringsimulation 0; scriptattribute_executionorder 1
scriptattribute_executioncount 2; childscriptattribute_automaticcascadingcalls 3; scriptattribute_enabled 4
childscriptattribute_enabled 4; customizationscriptattribute_cleanupbeforesave 5
# Execution order
scriptexecorder_first 0; scriptexecorder_normal 1; scriptexecorder_last 2
# Thread resume locations
scriptthreadresume_allnotyetresumed -1; scriptthreadresume_default 0; scriptthreadresume_actuation_first 1
scriptthreadresume_actuation_last 2; scriptthreadresume_sensing_first 3; scriptthreadresume_sensing_last 4
scriptthreadresume_custom 5
# Callback ids
callbackid_rossubscriber 1; callbackid_dynstep 2; callbackid_userdefined 1000
# Error report modes
api_error_report 1; api_error_output 2; api_warning_output 4; api_errormessage_ignore 0
api_errormessage_report 1; api_errormessage_output 2
# Special handles
handle_all -2; handle_all_except_explicit -3; handle_self -4; handle_main_script -5; handle_tree -6
handle_chain -7; handle_single -8; handle_default -9; handle_all_except_self -10; handle_parent -11
handle_scene -12; handle_app -13
# Handle flags
handleflag_assembly 0x400000; handleflag_togglevisibility 0x400000; handleflag_extended 0x400000
handleflag_greyscale 0x400000; handleflag_codedstring 0x400000; handleflag_camera 0x400000
handleflag_altname 0x400000; handleflag_model 0x800000; handleflag_rawvalue 0x1000000
handleflag_silenterror 0x2000000
# Path length calculation methods
distcalcmethod_dl 0; distcalcmethod_dac 1; distcalcmethod_max_dl_dac 2; distcalcmethod_dl_and_dac 3
distcalcmethod_sqrt_dl2_and_dac2 4; distcalcmethod_dl_if_nonzero 5; distcalcmethod_dac_if_nonzero 6
# Dialog styles
dlgstyle_message 0; dlgstyle_input 1; dlgstyle_ok 2; dlgstyle_ok_cancel 3; dlgstyle_yes_no 4
dlgstyle_dont_center 32
# Dialog results
dlgret_still_open 0; dlgret_ok 1; dlgret_cancel 2; dlgret_yes 3; dlgret_no 4
# Path properties
pathproperty_show_line 1; pathproperty_show_orientation 2; pathproperty_closed_path 4
pathproperty_automatic_orientation 8; pathproperty_invert_velocity_deprecated 16
pathproperty_infinite_acceleration_deprecated 32; pathproperty_flat_path 64; pathproperty_show_position 128
pathproperty_auto_velocity_profile_translation_deprecated 256
pathproperty_auto_velocity_profile_rotation_deprecated 512; pathproperty_endpoints_at_zero_deprecated 1024
pathproperty_keep_x_up 2048
# Drawing objects
drawing_points 0; drawing_lines 1; drawing_triangles 2; drawing_trianglepoints 3; drawing_quadpoints 4
drawing_discpoints 5; drawing_cubepoints 6; drawing_spherepoints 7; drawing_itemcolors 32
drawing_vertexcolors 64; drawing_itemsizes 128; drawing_backfaceculling 256; drawing_wireframe 512
drawing_painttag 1024; drawing_followparentvisibility 2048; drawing_cyclic 4096
drawing_50percenttransparency 8192; drawing_25percenttransparency 16384; drawing_12percenttransparency 32768
drawing_emissioncolor 0x10000; drawing_facingcamera 0x20000; drawing_overlay 0x40000
drawing_itemtransparency 0x80000; drawing_persistent 0x100000; drawing_auxchannelcolor1 0x200000
drawing_auxchannelcolor2 0x400000
# Banner options
banner_left 1; banner_right 2; banner_nobackground 4; banner_overlay 8; banner_followparentvisibility 16
banner_clickselectsparent 32; banner_clicktriggersevent 64; banner_facingcamera 128
banner_fullyfacingcamera 256; banner_backfaceculling 512; banner_keepsamesize 1024; banner_bitmapfont 2048
# Particle objects
particle_points1 0; particle_points2 1; particle_points4 2; particle_roughspheres 3; particle_spheres 4
particle_respondable1to4 32; particle_respondable5to8 64; particle_particlerespondable 128
particle_ignoresgravity 256; particle_invisible 512; particle_itemsizes 1024; particle_itemdensities 2048
particle_itemcolors 4096; particle_cyclic 8192; particle_emissioncolor 16384; particle_water 32768
particle_painttag 0x10000
# Boolean parameters
boolparam_hierarchy_visible 0; boolparam_console_visible 1; boolparam_collision_handling_enabled 2
boolparam_distance_handling_enabled 3; boolparam_ik_handling_enabled 4; boolparam_gcs_handling_enabled 5
boolparam_dynamics_handling_enabled 6; boolparam_joint_motion_handling_enabled_deprecated 7
boolparam_path_motion_handling_enabled_deprecated 8; boolparam_proximity_sensor_handling_enabled 9
boolparam_vision_sensor_handling_enabled 10; boolparam_mill_handling_enabled 11; boolparam_browser_visible 12
boolparam_scene_and_model_load_messages 13; boolparam_shape_textures_are_visible 15
boolparam_display_enabled 16; boolparam_infotext_visible 17; boolparam_statustext_open 18
boolparam_fog_enabled 19; boolparam_rml2_available 20; boolparam_rml4_available 21; boolparam_mirrors_enabled 22
boolparam_aux_clip_planes_enabled 23; boolparam_realtime_simulation 25; boolparam_use_glfinish_cmd 26
boolparam_force_show_wireless_emission 27; boolparam_force_show_wireless_reception 28
boolparam_video_recording_triggered 29; boolparam_threaded_rendering_enabled 32; boolparam_fullscreen 33
boolparam_headless 34; boolparam_hierarchy_toolbarbutton_enabled 35; boolparam_browser_toolbarbutton_enabled 36
boolparam_objectshift_toolbarbutton_enabled 37; boolparam_objectrotate_toolbarbutton_enabled 38
boolparam_force_calcstruct_all_visible 39; boolparam_force_calcstruct_all 40; boolparam_exit_request 41
boolparam_play_toolbarbutton_enabled 42; boolparam_pause_toolbarbutton_enabled 43
boolparam_stop_toolbarbutton_enabled 44; boolparam_waiting_for_trigger 45
boolparam_objproperties_toolbarbutton_enabled 46; boolparam_calcmodules_toolbarbutton_enabled 47
boolparam_rosinterface_donotrunmainscript 48; boolparam_online_mode 49; boolparam_scene_closing 52
boolparam_show_w_emitters 53; boolparam_show_w_receivers 54
# Integer parameters
intparam_error_report_mode 0; intparam_program_version 1; intparam_instance_count 2
intparam_custom_cmd_start_id 3; intparam_compilation_version 4; intparam_current_page 5
intparam_flymode_camera_handle 6; intparam_dynamic_step_divider 7; intparam_dynamic_engine 8
intparam_server_port_start 9; intparam_server_port_range 10; intparam_visible_layers 11
intparam_infotext_style 12; intparam_settings 13; intparam_edit_mode_type 14; intparam_server_port_next 15
intparam_qt_version 16; intparam_event_flags_read 17; intparam_event_flags_read_clear 18; intparam_platform 19
intparam_scene_unique_id 20; intparam_work_thread_count 21; intparam_mouse_x 22; intparam_mouse_y 23
intparam_core_count 24; intparam_work_thread_calc_time_ms 25; intparam_idle_fps 26
intparam_prox_sensor_select_down 27; intparam_prox_sensor_select_up 28; intparam_stop_request_counter 29
intparam_program_revision 30; intparam_mouse_buttons 31; intparam_dynamic_warning_disabled_mask 32
intparam_simulation_warning_disabled_mask 33; intparam_scene_index 34; intparam_motionplanning_seed 35
intparam_speedmodifier 36; intparam_dynamic_iteration_count 37
# uint64 parameters
uint64param_simulation_time_step_ns 0; uint64param_simulation_time_ns 1
# Float parameters
floatparam_rand 0; floatparam_simulation_time_step 1; floatparam_stereo_distance 2
floatparam_dynamic_step_size 3; floatparam_mouse_wheel_zoom_factor 4
# String parameters
stringparam_application_path 0; stringparam_video_filename 1; stringparam_app_arg1 2; stringparam_app_arg2 3
stringparam_app_arg3 4; stringparam_app_arg4 5; stringparam_app_arg5 6; stringparam_app_arg6 7
stringparam_app_arg7 8; stringparam_app_arg8 9; stringparam_app_arg9 10
stringparam_additional_addonscript_firstscene 11; stringparam_additional_addonscript 12
stringparam_scene_path_and_name 13; stringparam_scene_path 14; stringparam_scene_name 15
stringparam_remoteapi_temp_file_dir 16; stringparam_job 17; stringparam_job0 18; stringparam_job99 117
stringparam_scene_unique_id 118
# Array parameters
arrayparam_gravity 0; arrayparam_fog 1; arrayparam_fog_color 2; arrayparam_background_color1 3
arrayparam_background_color2 4; arrayparam_ambient_light 5; arrayparam_random_euler 6
# GUI items
gui_menubar 1; gui_popups 2; gui_toolbar1 4; gui_toolbar2 8; gui_hierarchy 16; gui_infobar 32; gui_statusbar 64
gui_scripteditor 128; gui_scriptsimulationparameters 256; gui_dialogs 512; gui_browser 1024; gui_all 65535
gui_headless 0x10000
# Joint modes
jointmode_passive 0; jointmode_motion_deprecated 1; jointmode_ik 2; jointmode_dependent 4; jointmode_force 5
# Navigation modes
navigation_passive 0; navigation_camerashift 1; navigation_camerarotate 2; navigation_camerazoom 3
navigation_cameratilt 4; navigation_cameraangle 5; navigation_camerafly 6; navigation_objectshift 7
navigation_objectrotate 8; navigation_createpathpoint 256; navigation_clickselection 512
navigation_ctrlselection 1024; navigation_shiftselection 2048; navigation_camerazoomwheel 4096
navigation_camerarotaterightbutton 8192; navigation_camerarotatemiddlebutton 8192
# RML flags
rml_phase_sync_if_possible 0; rml_only_time_sync 1; rml_only_phase_sync 2; rml_no_sync 3; rml_keep_target_vel 0
rml_recompute_trajectory 4; rml_disable_extremum_motion_states_calc 8
rml_keep_current_vel_if_fallback_strategy 16
# File dialog modes
filedlg_type_load 0; filedlg_type_save 1; filedlg_type_load_multiple 2; filedlg_type_folder 3
# Message box types
msgbox_type_info 0; msgbox_type_question 1; msgbox_type_warning 2; msgbox_type_critical 3
# Message box buttons
msgbox_buttons_ok 0; msgbox_buttons_yesno 1; msgbox_buttons_yesnocancel 2; msgbox_buttons_okcancel 3
# Message box results
msgbox_return_cancel 0; msgbox_return_no 1; msgbox_return_yes 2; msgbox_return_ok 3; msgbox_return_error 4
# Physics engines
physics_bullet 0; physics_ode 1; physics_vortex 2; physics_newton 3
# Pure primitives
pure_primitive_none 0; pure_primitive_plane 1; pure_primitive_disc 2; pure_primitive_cuboid 3
pure_primitive_spheroid 4; pure_primitive_cylinder 5; pure_primitive_cone 6; pure_primitive_heightfield 7
# Dummy link types
dummy_linktype_dynamics_loop_closure 0; dummy_linktype_dynamics_force_constraint 1
dummy_linktype_gcs_loop_closure 2; dummy_linktype_gcs_tip 3; dummy_linktype_gcs_target 4
dummy_linktype_ik_tip_target 5
# Texture mapping
texturemap_plane 0; texturemap_cylinder 1; texturemap_sphere 2; texturemap_cube 3
# Path planning types
pathplanning_holonomic 0; pathplanning_nonholonomic 2
# Holonomic path planning
holonomicpathplanning_xy 0; holonomicpathplanning_xg 1; holonomicpathplanning_xyz 2; holonomicpathplanning_xyg 3
holonomicpathplanning_abg 4; holonomicpathplanning_xyzg 5; holonomicpathplanning_xabg 6
holonomicpathplanning_xyabg 7; holonomicpathplanning_xyzabg 8
# Resource locks
lock_ui_wants_to_read 0; lock_ui_wants_to_write 1; lock_nonui_wants_to_write 2
# Color components
colorcomponent_ambient 0; colorcomponent_ambient_diffuse 0; colorcomponent_diffuse 1; colorcomponent_specular 2
colorcomponent_emission 3; colorcomponent_transparency 4; colorcomponent_auxiliary 5
# Volume types
volume_pyramid 0; volume_cylinder 1; volume_disc 2; volume_cone 3; volume_ray 4; volume_randomizedray 5
# Object parameters
objintparam_visibility_layer 10; objfloatparam_abs_x_velocity 11; objfloatparam_abs_y_velocity 12
objfloatparam_abs_z_velocity 13; objfloatparam_abs_rot_velocity 14; objfloatparam_objbbox_min_x 15
objfloatparam_objbbox_min_y 16; objfloatparam_objbbox_min_z 17; objfloatparam_objbbox_max_x 18
objfloatparam_objbbox_max_y 19; objfloatparam_objbbox_max_z 20; objfloatparam_modelbbox_min_x 21
objfloatparam_modelbbox_min_y 22; objfloatparam_modelbbox_min_z 23; objfloatparam_modelbbox_max_x 24
objfloatparam_modelbbox_max_y 25; objfloatparam_modelbbox_max_z 26
objintparam_collection_self_collision_indicator 27; objfloatparam_transparency_offset 28
objintparam_child_role 29; objintparam_parent_role 30; objintparam_manipulation_permissions 31
objintparam_illumination_handle 32; objstringparam_dna 33; objfloatparam_size_factor 34
visionfloatparam_near_clipping 1000; visionfloatparam_far_clipping 1001; visionintparam_resolution_x 1002
visionintparam_resolution_y 1003; visionfloatparam_perspective_angle 1004; visionfloatparam_ortho_size 1005
visionintparam_disabled_light_components 1006; visionintparam_rendering_attributes 1007
visionintparam_entity_to_render 1008; visionintparam_windowed_size_x 1009; visionintparam_windowed_size_y 1010
visionintparam_windowed_pos_x 1011; visionintparam_windowed_pos_y 1012; visionintparam_pov_focal_blur 1013
visionfloatparam_pov_blur_distance 1014; visionfloatparam_pov_aperture 1015
visionintparam_pov_blur_sampled 1016; visionintparam_render_mode 1017; jointintparam_motor_enabled 2000
jointintparam_ctrl_enabled 2001; jointfloatparam_pid_p 2002; jointfloatparam_pid_i 2003
jointfloatparam_pid_d 2004; jointfloatparam_intrinsic_x 2005; jointfloatparam_intrinsic_y 2006
jointfloatparam_intrinsic_z 2007; jointfloatparam_intrinsic_qx 2008; jointfloatparam_intrinsic_qy 2009
jointfloatparam_intrinsic_qz 2010; jointfloatparam_intrinsic_qw 2011; jointfloatparam_velocity 2012
jointfloatparam_spherical_qx 2013; jointfloatparam_spherical_qy 2014; jointfloatparam_spherical_qz 2015
jointfloatparam_spherical_qw 2016; jointfloatparam_upper_limit 2017; jointfloatparam_kc_k 2018
jointfloatparam_kc_c 2019; jointfloatparam_ik_weight 2021; jointfloatparam_error_x 2022
jointfloatparam_error_y 2023; jointfloatparam_error_z 2024; jointfloatparam_error_a 2025
jointfloatparam_error_b 2026; jointfloatparam_error_g 2027; jointfloatparam_error_pos 2028
jointfloatparam_error_angle 2029; jointintparam_velocity_lock 2030; jointintparam_vortex_dep_handle 2031
jointfloatparam_vortex_dep_multiplication 2032; jointfloatparam_vortex_dep_offset 2033
shapefloatparam_init_velocity_x 3000; shapefloatparam_init_velocity_y 3001; shapefloatparam_init_velocity_z 3002
shapeintparam_static 3003; shapeintparam_respondable 3004; shapefloatparam_mass 3005
shapefloatparam_texture_x 3006; shapefloatparam_texture_y 3007; shapefloatparam_texture_z 3008
shapefloatparam_texture_a 3009; shapefloatparam_texture_b 3010; shapefloatparam_texture_g 3011
shapefloatparam_texture_scaling_x 3012; shapefloatparam_texture_scaling_y 3013; shapeintparam_culling 3014
shapeintparam_wireframe 3015; shapeintparam_compound 3016; shapeintparam_convex 3017
shapeintparam_convex_check 3018; shapeintparam_respondable_mask 3019; shapefloatparam_init_velocity_a 3020
shapefloatparam_init_velocity_b 3021; shapefloatparam_init_velocity_g 3022; shapestringparam_color_name 3023
shapeintparam_edge_visibility 3024; shapefloatparam_shading_angle 3025; shapefloatparam_edge_angle 3026
shapeintparam_edge_borders_hidden 3027; proxintparam_ray_invisibility 4000; proxintparam_volume_type 4001
proxintparam_entity_to_detect 4002; forcefloatparam_error_x 5000; forcefloatparam_error_y 5001
forcefloatparam_error_z 5002; forcefloatparam_error_a 5003; forcefloatparam_error_b 5004
forcefloatparam_error_g 5005; forcefloatparam_error_pos 5006; forcefloatparam_error_angle 5007
lightintparam_pov_casts_shadows 8000; cameraintparam_disabled_light_components 9000
camerafloatparam_perspective_angle 9001; camerafloatparam_ortho_size 9002
cameraintparam_rendering_attributes 9003; cameraintparam_pov_focal_blur 9004
camerafloatparam_pov_blur_distance 9005; camerafloatparam_pov_aperture 9006
cameraintparam_pov_blur_samples 9007; dummyintparam_link_type 10000; dummyintparam_follow_path 10001
dummyfloatparam_follow_path_offset 10002; millintparam_volume_type 11000; mirrorfloatparam_width 12000
mirrorfloatparam_height 12001; mirrorfloatparam_reflectance 12002; mirrorintparam_enable 12003
pplanfloatparam_x_min 20000; pplanfloatparam_x_range 20001; pplanfloatparam_y_min 20002
pplanfloatparam_y_range 20003; pplanfloatparam_z_min 20004; pplanfloatparam_z_range 20005
pplanfloatparam_delta_min 20006; pplanfloatparam_delta_range 20007; mplanintparam_nodes_computed 25000
mplanintparam_prepare_nodes 25001; mplanintparam_clear_nodes 25002
# Stack table info
stack_table_not_table -3; stack_table_map -2; stack_table_empty 0
# Bullet solver types
bullet_constraintsolvertype_sequentialimpulse 0; bullet_constraintsolvertype_nncg 1
bullet_constraintsolvertype_dantzig 2; bullet_constraintsolvertype_projectedgaussseidel 3
# Dynamic property bits
objdynprop_dynamic 1; objdynprop_respondable 2
# Physics warnings
announce_pureconenotsupported 0; announce_purespheroidnotsupported 1; announce_containsnonpurenonconvexshapes 2
announce_containsstaticshapesondynamicconstruction 3; announce_purehollowshapenotsupported 4
announce_vortexpluginisdemo 5; announce_newtondynamicrandommeshnotsupported 6
# Dynamic icons
dynamicsimicon_none 0; dynamicsimicon_objectisdynamicallysimulated 1
dynamicsimicon_objectisnotdynamicallyenabled 2
# Vision filter components
filtercomponent_originalimage 1; filtercomponent_originaldepth 2; filtercomponent_uniformimage 3
filtercomponent_tooutput 4; filtercomponent_tobuffer1 5; filtercomponent_tobuffer2 6
filtercomponent_frombuffer1 7; filtercomponent_frombuffer2 8; filtercomponent_swapbuffers 9
filtercomponent_addbuffer1 10; filtercomponent_subtractbuffer1 11; filtercomponent_multiplywithbuffer1 12
filtercomponent_horizontalflip 13; filtercomponent_verticalflip 14; filtercomponent_rotate 15
filtercomponent_shift 16; filtercomponent_resize 17; filtercomponent_3x3filter 18; filtercomponent_5x5filter 19
filtercomponent_sharpen 20; filtercomponent_edge 21; filtercomponent_rectangularcut 22
filtercomponent_circularcut 23; filtercomponent_normalize 24; filtercomponent_intensityscale 25
filtercomponent_keeporremovecolors 26; filtercomponent_scaleandoffsetcolors 27; filtercomponent_binary 28
filtercomponent_swapwithbuffer1 29; filtercomponent_addtobuffer1 30; filtercomponent_subtractfrombuffer1 31
filtercomponent_correlationwithbuffer1 32; filtercomponent_colorsegmentation 33
filtercomponent_blobextraction 34; filtercomponent_imagetocoord 35; filtercomponent_pixelchange 36
filtercomponent_velodyne 37; filtercomponent_todepthoutput 38; filtercomponent_customized 1000
# Buffer formats
buffer_uint8 0; buffer_int8 1; buffer_uint16 2; buffer_int16 3; buffer_uint32 4; buffer_int32 5; buffer_float 6
buffer_double 7; buffer_uint8rgb 8; buffer_uint8bgr 9; buffer_uint8rgba 10; buffer_uint8argb 11
buffer_base64 12; buffer_split 13
# Image combination
imgcomb_vertical 0; imgcomb_horizontal 1
# Dynamic material ids
dynmat_default 2310013; dynmat_highfriction 2310014; dynmat_lowfriction 2310015; dynmat_nofriction 0x233f80
dynmat_reststackgrasp 2310017; dynmat_foot 2310018; dynmat_wheel 2310019; dynmat_gripper 2310020
dynmat_floor 2310021
# Physics engine parameter id ranges
bullet_global_stepsize 1; bullet_body_friction 6003; bullet_body_oldfriction 6002; bullet_body_restitution 6001
bullet_body_lineardamping 6004; bullet_body_angulardamping 6005; ode_body_friction 15001
newton_body_staticfriction 33001; newton_body_kineticfriction 33002; vortex_body_primlinearaxisfriction 24001
# Additions of CoppeliaSim 4.0 to 4.7
object_script_type 17
ik_undamped_pseudo_inverse_method 3
objectspecialproperty_detectable 496
message_eventcallback_lastinstancepass 336; message_eventcallback_uipass 337
message_eventcallback_scriptstateabouttobedestroyed 338; message_eventcallback_scriptstatedestroyed 338
message_eventcallback_scriptabouttobedestroyed 339; message_eventcallback_scriptdestroyed 339
message_eventcallback_simulationinit 340; message_eventcallback_simulationactuation 341
message_eventcallback_simulationsensing 342; message_eventcallback_simulationcleanup 343
message_eventcallback_moduleentry 344; message_eventcallback_events 345
objectproperty_ignoreviewfitting 1; objectproperty_hierarchyhiddenmodelchild 32768
objectproperty_hiddenforsimulation 0x10000
scripttype_main 0; scripttype_simulation 1; scripttype_addon 2; scripttype_customization 6; scripttype_sandbox 8
scripttype_passive 9
lang_undefined -1; lang_lua 0; lang_python 1
scriptattribute_debuglevel 6; scriptattribute_scripttype 7; scriptattribute_scripthandle 8
scripttreetraversal_reverse 0; scripttreetraversal_forward 1; scripttreetraversal_parent 2
scriptdebug_none 0; scriptdebug_syscalls 1; scriptdebug_vars_interval 2; scriptdebug_allcalls 3
scriptdebug_vars 4; scriptdebug_callsandvars 5
scriptthreadresume_launch -2
handle_world -1; handle_inverse -14; handle_appstorage -15
handleflag_wxyzquat 0x1000000; handleflag_reljointbaseframe 0x400000; handleflag_setmultiple 0x400000
handleflag_addmultiple 0x1000000; handleflag_abscoords 0x800000; handleflag_depthbuffer 0x800000
handleflag_depthbuffermeters 0x800000; handleflag_keeporiginal 0x400000; handleflag_axis 0x400000
handleflag_resetforce 0x400000; handleflag_resettorque 0x800000; handleflag_resetforcetorque 0xc00000
drawing_spherepts 7; drawing_linestrip 8; drawing_trianglepts 9; drawing_quadpts 10; drawing_discpts 11
drawing_cubepts 12; drawing_local 0x800000
boolparam_xr_partrepository 50; boolparam_xr_palletrepository 51; boolparam_xr_jobfunc 55; boolparam_rayvalid 56
boolparam_qglwidget 57; boolparam_execunsafe 58; boolparam_execunsafeext 59; boolparam_cansave 60
boolparam_usingscriptobjects 61
intparam_job_count 38; intparam_program_full_version 39; intparam_verbosity 40; intparam_statusbarverbosity 41
intparam_dlgverbosity 42; intparam_videoencoder_index 43; intparam_exitcode 44; intparam_bugfix1 45
intparam_mouseclickcounterdown 46; intparam_mouseclickcounterup 47; intparam_objectcreationcounter 48
intparam_objectdestructioncounter 49; intparam_hierarchychangecounter 50; intparam_processid 52
intparam_processcnt 53
floatparam_physicstimestep 5; floatparam_maxtrisizeabs 6; floatparam_mintrisizerel 7
stringparam_additional_addonscript1 11; stringparam_additional_addonscript2 12; stringparam_machine_id 119
stringparam_machine_id_legacy 120; stringparam_verbosity 121; stringparam_statusbarverbosity 122
stringparam_dlgverbosity 123; stringparam_consolelogfilter 124; stringparam_startupscriptstring 125
stringparam_uniqueid 126; stringparam_tempdir 127; stringparam_tempscenedir 128; stringparam_datadir 129
stringparam_importexportdir 130; stringparam_addonpath 131; stringparam_scenedefaultdir 132
stringparam_modeldefaultdir 133; stringparam_defaultpython 134; stringparam_additionalpythonpath 135
stringparam_luadir 136; stringparam_pythondir 137; stringparam_usersettingsdir 139; stringparam_systemdir 140
stringparam_resourcesdir 141; stringparam_legacymachinetag 142; stringparam_addondir 143
stringparam_sandboxlang 144
arrayparam_rayorigin 7; arrayparam_raydirection 8
gui_splash 2048
jointmode_kinematic 0; jointmode_dynamic 5
jointdynctrl_free 0; jointdynctrl_force 1; jointdynctrl_velocity 4; jointdynctrl_position 8
jointdynctrl_positioncb 9; jointdynctrl_spring 12; jointdynctrl_springcb 13; jointdynctrl_callback 16
verbosity_useglobal -1; verbosity_none 100; verbosity_errors 200; verbosity_warnings 300
verbosity_loadinfos 400; verbosity_questions 410; verbosity_scripterrors 420; verbosity_scriptwarnings 430
verbosity_scriptinfos 450; verbosity_msgs 450; verbosity_infos 500; verbosity_debug 600; verbosity_trace 700
verbosity_tracelua 800; verbosity_traceall 900; verbosity_default 400; verbosity_undecorated 61440
verbosity_onlyterminal 0x10000; verbosity_once 0x20000
plugininfo_extversionstr 0; plugininfo_builddatestr 1; plugininfo_extversionint 2; plugininfo_verbosity 3
plugininfo_statusbarverbosity 4
moduleinfo_extversionstr 0; moduleinfo_builddatestr 1; moduleinfo_extversionint 2; moduleinfo_verbosity 3
moduleinfo_statusbarverbosity 4
ruckig_phasesync 0; ruckig_timesync 1; ruckig_nosync 3; ruckig_minvel 256; ruckig_minaccel 512
physics_physx 5
primitiveshape_none 0; primitiveshape_plane 1; primitiveshape_disc 2; primitiveshape_cuboid 3
primitiveshape_spheroid 4; primitiveshape_cylinder 5; primitiveshape_cone 6; primitiveshape_heightfield 7
primitiveshape_capsule 8
dummytype_dynloopclosure 0; dummytype_dyntendon 7; dummytype_default 8; dummytype_assembly 9
dummylink_dynloopclosure 0; dummylink_dyntendon 7
objstringparam_unique_id 35
objintparam_visible 36; objintparam_unique_id 37; objintparam_hierarchycolor 38
visionintparam_perspective_operation 1018; visionintparam_rgbignored 1020; visionintparam_depthignored 1021
visionfarrayparam_viewfrustum 1019
jointfloatparam_screw_pitch 2034; jointfloatparam_step_size 2035; jointfloatparam_maxvel 2036
jointfloatparam_maxaccel 2037; jointfloatparam_maxjerk 2038; jointfloatparam_screwlead 2042
jointintparam_dynctrlmode 2039; jointintparam_dynvelctrltype 2040; jointintparam_dynposctrltype 2041
shapefloatparam_init_ang_velocity_x 3020; shapefloatparam_init_ang_velocity_y 3021
shapefloatparam_init_ang_velocity_z 3022
shapeintparam_component_cnt 3028; shapeintparam_sleepmodestart 3029; shapeintparam_kinematic 3030
shapeintparam_respondablesuspendcnt 3031
shapestringparam_colorname 3032
lightfloatparam_spot_exponent 8001; lightfloatparam_spot_cutoff 8002; lightfloatparam_const_attenuation 8003
lightfloatparam_lin_attenuation 8004; lightfloatparam_quad_attenuation 8005
camerafloatparam_near_clipping 9008; camerafloatparam_far_clipping 9009
cameraintparam_perspective_operation 9010; cameraintparam_trackedobject 9011
cameraintparam_remotecameramode 9012
camerafarrayparam_viewfrustum 9013
dummyintparam_dummytype 10000
dummyfloatparam_size 10003
dummystringparam_assemblytag 10004
scriptintparam_execorder 10100; scriptintparam_execcount 10101; scriptintparam_type 10102
scriptintparam_handle 10103; scriptintparam_enabled 10104; scriptintparam_objecthandle 10105
scriptintparam_lang 10106; scriptintparam_autorestartonerror 10107
scriptstringparam_description 10108; scriptstringparam_name 10109; scriptstringparam_text 10110
scriptstringparam_nameext 10111; scriptstringparam_lang 10112
graphintparam_needs_refresh 10500
octreefloatparam_voxelsize 13000
string_text 0; string_binary 1; string_buffer 2
stackitem_null 0; stackitem_double 1; stackitem_bool 2; stackitem_string 3; stackitem_table 4; stackitem_func 5
stackitem_userdat 6; stackitem_thread 7; stackitem_lightuserdat 8; stackitem_integer 9
stack_table_circular_ref -4
vortex_body_secangularaxisfrictionmodel 25004; vortex_body_normalangularaxisfrictionmodel 25005
buffer_clamp 256
stream_transf_raw 0; stream_transf_derivative 1; stream_transf_integral 2; stream_transf_cumulative 3
rendermode_opengl 0; rendermode_auxchannels 1; rendermode_colorcoded 2; rendermode_povray 3
rendermode_extrenderer 5; rendermode_extrendererwindowed 6; rendermode_opengl3 7; rendermode_opengl3windowed 8
rendermode_oglimg 9; rendermode_codedimg 10
# Shorter names of later versions
sceneobject_shape 0; sceneobject_joint 1; sceneobject_graph 2; sceneobject_camera 3; sceneobject_dummy 4
sceneobject_proximitysensor 5; sceneobject_path 8; sceneobject_visionsensor 9; sceneobject_mill 11
sceneobject_forcesensor 12; sceneobject_light 13; sceneobject_mirror 14; sceneobject_octree 15
sceneobject_pointcloud 16; sceneobject_script 17; light_omnidirectional 1; light_spot 2; light_directional 3; joint_revolute 10
joint_prismatic 11; joint_spherical 12; shape_simple 20; shape_compound 21; proximitysensor_pyramid 30
proximitysensor_cylinder 31; proximitysensor_disc 32; proximitysensor_cone 33; proximitysensor_ray 34
objecttype_sceneobject 109; objecttype_texture 120; simulation_running 17; simulation_lastbeforestop 22
";

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeMap;

    #[test]
    fn every_constant_is_read_once() {
        let items = TABLE.lines().filter(|l| !l.starts_with('#')).flat_map(|l| l.split(';')).count();
        let names: BTreeMap<_, _> = all().collect();
        assert_eq!(names.len(), items);
    }

    #[test]
    fn constants_have_the_values_of_vrep() {
        let names: BTreeMap<_, _> = all().collect();
        for (name, value) in [
            ("handle_self", -4),
            ("handle_world", -1),
            ("handleflag_model", 0x80_0000),
            ("message_keypress", 6),
            ("childscriptcall_sensing", 3),
            ("shapeintparam_static", 3003),
            ("jointdynctrl_position", 8),
            ("scripttype_childscript", 1),
            ("object_proximitysensor_type", 5),
            ("primitiveshape_cuboid", 3),
        ] {
            assert_eq!(names.get(name), Some(&value), "{name}");
        }
    }
}

//! The types of the plugin interface as declared in Rust, one row per type, with the fields in the order of the header.
//!
//! The tests in `header` compare the rows with the header and with the layout computed by a C compiler, and fail if a
//! row or field is missing.

use core::mem::{align_of, offset_of, size_of};

use tatu_plugin_api::abi;

/// A field, with its offset, size and alignment in bytes.
pub struct Field {
    pub name: &'static str,
    pub at: usize,
    pub size: usize,
    pub align: usize,
}

/// A type with its size in bytes and its fields.
pub struct Type {
    pub name: &'static str,
    pub size: usize,
    pub fields: Vec<Field>,
}

fn measure<T, F>(name: &'static str, at: usize, _: fn(&T) -> &F) -> Field {
    // Fields whose names are Rust keywords end with an underscore.
    Field { name: name.trim_end_matches('_'), at, size: size_of::<F>(), align: align_of::<F>() }
}

macro_rules! mirror {
    ($($name:ident { $($field:ident),* })*) => {
        /// Returns all types.
        pub fn types() -> Vec<Type> {
            vec![$(Type {
                name: stringify!($name),
                size: size_of::<abi::$name>(),
                fields: vec![$(measure(
                    stringify!($field),
                    offset_of!(abi::$name, $field),
                    |t: &abi::$name| &t.$field,
                )),*],
            }),*]
        }
    };
}

mirror! {
    tatu_str { ptr, len }
    tatu_value { tag, reserved, u }
    tatu_pair { key, value }
    tatu_field_view { ptr, len, elem, dims, time, sequence }
    tatu_contact { shape, point, normal, force }
    tatu_error { size, code, ctx, say, add, text, help, file, traceback, line }
    tatu_host { size, abi_minor, ctx, service, assets }
    tatu_need { size, optional, id, bytes, minor }
    tatu_plugin_t { size, abi_major, abi_minor, id, name, version, licence, needs, init, shutdown, extension }
    tatu_param { size, type_, count, flags, key, unit, lowest, highest, fallback, choices, text, keys }
    tatu_instance { size, n_params, world, owner, id, seed, params, state, session }
    tatu_writer { size, reserved, ctx, write }
    tatu_life { size, state_bytes, create, destroy, configure, save, load, version, reserved, end_run }
    tatu_call_api { size, reserved, alloc, wait, ticket, woken }
    tatu_call {
        size, command, alias, n_args, args, results, results_cap, n_results, world, self_, instance, state,
        user, api, error, wait_token, resume, caller, caller_object, caller_script, caller_dialect,
        caller_kind, flags
    }
    tatu_name { size, flags, name, n_on_error, reserved, on_error, on_error_until }
    tatu_command { size, flags, names, params, returns, text, example, no_wait, user, call, status, reserved, notes, subject }
    tatu_constant { size, reserved, name, value }
    tatu_prelude { size, reserved, language, module, text }
    tatu_kind_mark { size, flags, language, kind, word }
    tatu_ext_command { size, reserved, commands, constants, preludes, per_world, kind_marks }
    tatu_beams { size, form, count, near_m, far_m, dims, max_incidence, directions, flags, reserved, waves, reserved2,
        own, without, reserved3, origins, observed, n_targets, reserved4 }
    tatu_field { size, elem, dims, flags, name, unit, text, valid, nothing }
    tatu_sensor_batch {
        size, n, n_fields, reserved, time, step, data, state, sensor, first_beam, distance, point, normal,
        object, pose, twist, fields, status, color, primitive, first_pixel, depth, pixel_color, pixel_cosine,
        pixel_object, random, rays, lengths, dt, gravity, acceleration, joint, first_contact, contact, friction, wrench,
        hit_twist, first_target, target, target_pose, target_twist
    }
    tatu_random { size, reserved, ctx, uniform, normal }
    tatu_preset { size, reserved, id, text, settings }
    tatu_sensor { size, inputs, id, text, schemas, params, fields, life, beams, measure, presets, finish, aim, flags, reserved }
    tatu_ext_sensor { size, reserved, kinds }
    tatu_actuator_batch {
        size, n, time, dt, data, state, actuator, pose, twist, joint, command, wrench, effort, status,
        fields, lengths, n_fields, reserved, first_target, target, target_pose, target_twist, target_wrench,
        first_contact, contact, friction
    }
    tatu_actuator {
        size, flags, n_commands, reserved, id, text, params, commands, life, apply, schemas, fields, inputs, reserved2
    }
    tatu_ext_actuator { size, reserved, kinds }
    tatu_part_call {
        size, n_fields, world, part, owner, time, dt, step, physics_step, n_physics_steps, state, command, fields, lengths
    }
    tatu_part {
        size, flags, id, text, params, commands, life, actuate, physics_step, sense, paused, end, schemas, fields, presets,
        event, events, contact
    }
    tatu_contact_pair { size, touching, contact, collide, reserved, friction, restitution, surface }
    tatu_ext_part { size, reserved, kinds }
    tatu_builder { size, reserved, ctx, object, set, mesh, image, script, device, report, file, describe, model, scene, textured_mesh }
    tatu_model_slot { size, reserved, alias, mount, text, payload }
    tatu_model_number { size, reserved, name, value, unit, source }
    tatu_model {
        size, flags, id, text, params, slots, build, category, licence, mounts, slot_infos, numbers
    }
    tatu_ext_model { size, reserved, models, read }
    tatu_importer { size, reserved, id, text, suffixes, params, sniff, load }
    tatu_ext_importer { size, reserved, importers }
    tatu_budget { size, reserved, instructions, memory }
    tatu_language {
        size, flags, id, text, suffixes, life, load, find, call, resume, keep_func, drop_func, call_func,
        knows_dialect, traits, order, place, permission, params
    }
    tatu_ext_script { size, reserved, languages }
    tatu_service { size, flags, id, text, params, life, barrier, event, resume, events, call_func, last }
    tatu_ext_service { size, reserved, services }
    tatu_event { size, reserved, name, text, fields }
    tatu_ext_event { size, reserved, events, heard, listens }
    tatu_host_scene {
        size, reserved, prop, get, set, get_f64, set_f64, get_f64_many, set_f64_many, pose, set_pose, look,
        find, create, remove, list, copy, load, save, row, model
    }
    tatu_host_stand_ins { size, reserved, made, object, used, parent, child, script, value }
    tatu_look { size, flags, only, far_m, max_incidence }
    tatu_host_readings { size, reserved, field, sense_now, reset, list, describe, look }
    tatu_host_bodies {
        size, reserved, twist, set_twist, push, impulse, contacts, closest, is_dynamic, frictions,
        closest_at, hook
    }
    tatu_host_commands {
        size, reserved, find, is_name_space, count, describe, call, generation, constant, prelude, mark, alloc, release,
        retain, drop, call_func, constant_name, wake
    }
    tatu_host_scripts { size, reserved, list, call, broadcast, options, add, call_below, text, change }
    tatu_host_signals { size, reserved, get, set, clear, name }
    tatu_host_events { size, reserved, publish, subscribe, unsubscribe, wanted, declared }
    tatu_host_session { size, reserved, request, wake, worlds, client, state, input, put_in, open, observed, observe, interrupted, function, stop, must_return }
    tatu_host_stage { size, reserved, run }
    tatu_host_log { size, reserved, write, last_error }
    tatu_host_files { size, reserved, resolve, open }
    tatu_host_figures { size, reserved, add, change, put, record, list, get, part, image }
    tatu_host_edits { size, reserved, begin, end, step_back, state, save, copy, open, add, kind }
    tatu_test_setup { size, reserved, scene, folder, plugins }
    tatu_test_host {
        size, reserved, open, close, step, time, field, reading, get, set, call, lines, faults, last_error
    }
    tatu_test { size, failures, host, folder, plugins, world, leave, ctx, report }
    tatu_test_case { size, line, name, file, run }
    tatu_test_list { size, abi_major, abi_minor, cases }
}

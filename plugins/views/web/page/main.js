// @ts-check
// Loads the modules of the page, and connects to the program. README.md in the folder above lists the folders and modules.

import { translateDocument } from "tatu/lib/language";
import { connect } from "tatu/net/connection";
import "tatu/scene/store";
import "tatu/run/run_controls";
import "tatu/panels/output";
import "tatu/panels/tree";
import "tatu/panels/property_panel";
import "tatu/panels/scene_panel";
import "tatu/panels/joint_sliders";
import "tatu/documents/gallery";
import "tatu/documents/scene_file";
import "tatu/documents/dropped_files";
import "tatu/panels/shortcuts";
import "tatu/run/key_events";
import "tatu/run/drive_keys";
import "tatu/lib/icons";
import "tatu/view/renderer";
import "tatu/view/camera_controls";
import "tatu/view/drag_mode";
import "tatu/edit/view_selection";
import "tatu/edit/placement";
import "tatu/edit/palette";
import "tatu/edit/undo_buttons";
import "tatu/panels/tree_actions";
import "tatu/edit/alignment";
import "tatu/edit/gizmo";
import "tatu/edit/move_keys";
import "tatu/edit/pose_toolbar";
import "tatu/edit/snap_settings";
import "tatu/run/push";
import "tatu/view/sensor_readings";
import "tatu/view/sensor_volumes";
import "tatu/view/drawings";
import "tatu/view/overlays";
import "tatu/documents/script_editor";
import "tatu/windows/script_windows";
import "tatu/windows/window_menu";
import "tatu/run/film_recorder";
import "tatu/run/exercise";
import "tatu/panels/splitters";
import "tatu/panels/drawers";
import "tatu/documents/address_actions";
import "tatu/net/connection_banner";

translateDocument(document);
connect();

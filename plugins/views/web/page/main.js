// @ts-check
// Loads the modules of the page, and connects to the program.

import { connect } from "tatu/net";
import "tatu/store";
import "tatu/controls";
import "tatu/tree";
import "tatu/details";
import "tatu/joints";
import "tatu/output";
import "tatu/gallery";
import "tatu/saving";
import "tatu/incoming";
import "tatu/shortcuts";
import "tatu/keys";
import "tatu/driving";
import "tatu/icons";
import "tatu/view";
import "tatu/looking";
import "tatu/dragging";
import "tatu/selecting";
import "tatu/placing";
import "tatu/palette";
import "tatu/treeing";
import "tatu/arrange";
import "tatu/moving";
import "tatu/nudging";
import "tatu/typing";
import "tatu/snap";
import "tatu/pushing";
import "tatu/sensing";
import "tatu/volumes";
import "tatu/drawings";
import "tatu/overlays";
import "tatu/editor";
import "tatu/script_windows";
import "tatu/pane_menu";
import "tatu/filming";
import "tatu/exercise";
import "tatu/splitters";
import "tatu/links";
import "tatu/lost";

connect();

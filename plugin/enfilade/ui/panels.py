# SPDX-License-Identifier: GPL-3.0-or-later
"""The Enfilade tab of the 3D view's sidebar. Reads `panel_data`, computes nothing."""

from __future__ import annotations

import blf
import bpy

from .. import compat, native
from ..ops import repair
from ..ops.common import registration, running
from ..rules import ifc_library
from ..rules.names import sentence
from . import error_log, panel_data


class _Tab:
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Enfilade"


class VIEW3D_PT_enfilade_missing(_Tab, bpy.types.Panel):
    """Shown instead of everything else when the core can't be loaded"""

    bl_label = "Enfilade"

    def draw(self, context):
        _, line = native.status()
        box = self.layout.box()
        box.label(text="The core can't be used:", icon="ERROR")
        _paragraph(box.column(align=True), line, context, 16)
        self.layout.operator("enfilade.copy_diagnostics", icon="COPYDOWN")


class VIEW3D_PT_enfilade(_Tab, bpy.types.Panel):
    bl_label = "Enfilade"

    def draw(self, context):
        layout = self.layout
        settings = context.scene.enfilade
        data = panel_data.of(context.scene)
        column = layout.column(align=True)
        _named(column, "Source").prop(settings, "source", text="")
        if settings.source == "ifc" or (settings.source == "auto" and settings.ifc_path):
            _named(column, "IFC file").prop(settings, "ifc_path", text="")
            if not ifc_library.seems_there():
                _note(column, "IFC files can't be read: IfcOpenShell is missing. Bonsai brings it; or install it by a command:", "ERROR", context)
                column.operator("enfilade.copy_ifc_command", icon="COPYDOWN")
        row = layout.row()
        row.scale_y = 1.3
        row.operator("enfilade.detect", icon="VIEWZOOM", text="Detect Again" if data.detected else "Detect")
        for task in running:
            row = layout.row(align=True)
            compat.progress_bar(row, task.fraction, f"{sentence(task.doing)}, {task.fraction:.0%}")
            row.operator("enfilade.stop", icon="CANCEL", text="")
        if data.stale:
            layout.label(text="Something changed: detect again", icon="ERROR")
        elif data.moved:
            layout.label(text=f"{data.moved} moved since Detect", icon="INFO")
        if not data.detected and not running:
            hint = layout.column(align=True)
            hint.active = False
            _paragraph(hint, "Finds rooms, doors and windows: of an IFC file, of marked objects, or of what is drawn.", context)
        if data.detected and context.scene.camera is None:
            layout.operator("enfilade.add_cameras", icon="OUTLINER_OB_CAMERA")
        row = layout.row()
        row.scale_y = 1.3
        row.operator("enfilade.culled_view", icon="HIDE_OFF" if data.live else "CAMERA_DATA", depress=data.live,
                     text="Culled View: On" if data.live else "Culled View")
        _named(layout, "Follow").row(align=True).prop(settings, "follow", expand=True)
        column = layout.column(align=True)
        column.operator("enfilade.visible_from_here", icon="HIDE_OFF")
        column.operator("enfilade.bake_rooms", icon="LINKED")
        column.operator("enfilade.preview", icon="IMAGE_DATA")
        column.operator("enfilade.report", icon="TEXT").open_after = True
        if data.applied:
            box = layout.box()
            box.label(text=data.applied, icon="HIDE_ON")
            box.operator("enfilade.restore", icon="LOOP_BACK")


class VIEW3D_PT_enfilade_found(_Tab, bpy.types.Panel):
    bl_label = "Found"
    bl_parent_id = "VIEW3D_PT_enfilade"

    @classmethod
    def poll(cls, context):
        return panel_data.of(context.scene).detected

    def draw(self, context):
        data = panel_data.of(context.scene)
        _figures(self.layout, data.figures)
        if data.baked:
            few = f"Sightlines from {data.sightlines_of}" if data.sightlines_of else "Sightlines as Curves"
            op = self.layout.operator("enfilade.draw_sightlines", icon="CURVE_PATH", text=few)
            op.room, op.toggle = data.sightlines_of, True


class VIEW3D_PT_enfilade_seen(_Tab, bpy.types.Panel):
    bl_label = "Seen"
    bl_parent_id = "VIEW3D_PT_enfilade"

    @classmethod
    def poll(cls, context):
        return bool(panel_data.of(context.scene).seen_from)

    def draw(self, context):
        data = panel_data.of(context.scene)
        self.layout.label(text=data.seen_from, icon="VIEW_CAMERA")
        if data.seen_whole:
            box = self.layout.box().column(align=True)
            box.label(text="Not culled", icon="ERROR")
            _paragraph(box, data.seen_whole, context, 16)
        _figures(self.layout, data.seen_figures)
        column = self.layout.column(align=True)
        for room, way in data.seen:
            column.label(text=room, icon="CHECKMARK")
            if way:
                through = column.column(align=True)
                through.active = False
                through.label(text=f"through {way}", icon="BLANK1")


class VIEW3D_PT_enfilade_problems(_Tab, bpy.types.Panel):
    bl_label = "Problems"
    bl_parent_id = "VIEW3D_PT_enfilade"

    @classmethod
    def poll(cls, context):
        return bool(panel_data.of(context.scene).problems or error_log.entries())

    def draw_header_preset(self, context):
        errors, warnings, infos = panel_data.of(context.scene).problem_counts
        # The gravest kind alone: a narrow sidebar has no room for more beside the title.
        counts = ((errors, "error"), (warnings, "warning"), (infos, "note"))
        text = next((f"{n} {word}{'s' * (n != 1)}" for n, word in counts if n), "")
        self.layout.label(text=text)

    def draw(self, context):
        data = panel_data.of(context.scene)
        muted = context.scene.enfilade.muted
        for item in data.problems:
            row = self.layout.box().row()
            row.label(text="", icon=item.icon)
            column = row.column(align=True)
            _paragraph(column, item.message + (f" ({item.count} like this)" if item.count > 1 else ""), context, 70)
            if item.remedy:
                fix = column.column(align=True)
                fix.active = False
                _paragraph(fix, item.remedy, context, 70)
            tools = row.column(align=True)
            op = tools.operator("enfilade.show_problem", text="", icon="ZOOM_SELECTED", emboss=False)
            op.index, op.alike = item.index, item.count > 1
            if item.placed:
                hidden = item.code in muted
                tools.operator("enfilade.mute_problem", text="", icon="HIDE_ON" if hidden else "HIDE_OFF", emboss=False).code = item.code
        if data.problems_left:
            self.layout.label(text=f"and {data.problems_left} other kinds: see the report")
        for entry in error_log.entries():
            box = self.layout.box()
            _paragraph(box, f"{entry.where}: {entry.message}" + (f" (x{entry.count})" if entry.count > 1 else ""), context)
        row = self.layout.row(align=True)
        row.operator("enfilade.mark_problems", icon="EMPTY_AXIS")
        row.operator("enfilade.copy_diagnostics", icon="COPYDOWN")


class VIEW3D_PT_enfilade_cull(_Tab, bpy.types.Panel):
    bl_label = "Cull for Rendering"
    bl_parent_id = "VIEW3D_PT_enfilade"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        settings = context.scene.enfilade
        layout = self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        layout.prop(settings, "mode")
        layout.prop(settings, "keep")
        if settings.keep == "bounces":
            layout.prop(settings, "bounces")
        layout.prop(settings, "method")
        layout.prop(settings, "occluders")
        if settings.mode == "safe" and context.scene.render.engine != "CYCLES":
            _note(layout, "Camera rays are known to Cycles alone: choose Renders", "ERROR", context)
        if settings.mode == "render" and settings.keep == "camera":
            _note(layout, "Light will change where what casts it is hidden", "INFO", context)
        row = layout.row(align=True)
        row.operator("enfilade.cull", icon="CAMERA_DATA", text="This Camera").all_cameras = False
        row.operator("enfilade.cull", text="All Cameras").all_cameras = True
        layout.operator("enfilade.bake_frames", icon="RENDER_ANIMATION")


class VIEW3D_PT_enfilade_show(_Tab, bpy.types.Panel):
    bl_label = "Show"
    bl_parent_id = "VIEW3D_PT_enfilade"
    bl_options = {"DEFAULT_CLOSED"}

    def draw_header(self, context):
        self.layout.prop(context.scene.enfilade, "show_overlay", text="")

    def draw(self, context):
        settings = context.scene.enfilade
        column = self.layout.column(align=True)
        column.active = settings.show_overlay
        for name in ("show_rooms", "show_openings", "show_sightlines", "show_problems"):
            column.prop(settings, name)
        self.layout.operator("enfilade.draw_cells", icon="MESH_CUBE")


class VIEW3D_PT_enfilade_openings(_Tab, bpy.types.Panel):
    bl_label = "Open and Closed"
    bl_parent_id = "VIEW3D_PT_enfilade"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context):
        return panel_data.of(context.scene).detected

    def draw(self, context):
        layout = self.layout
        data = panel_data.of(context.scene)
        name = data.opening_of.get(context.active_object.name_full, "") if context.active_object else ""
        self._row(layout, "OPENING", name, name or "Make a door or window active", bool(name))
        for storey in data.storeys:
            self._row(layout, "STOREY", storey, storey, True)
        for kind in ("door", "window", "hole"):
            self._row(layout, "CLASS", kind, f"All {kind}s", True)
        if data.rules:
            box = layout.box().column(align=True)
            for key, state in data.rules:
                box.label(text=f"{key}: {state}", icon="DOT")

    @staticmethod
    def _row(layout, scope: str, name: str, text: str, usable: bool) -> None:
        column = layout.column(align=True)
        column.enabled = usable
        column.label(text=text)
        row = column.row(align=True)
        for state, word, icon in (("open", "Open", "NONE"), ("closed", "Closed", "NONE"), ("glass", "Glass", "NONE"), ("found", "", "LOOP_BACK")):
            op = row.operator("enfilade.set_opening_state", text=word, icon=icon)
            op.scope, op.name, op.state = scope, name, state


class VIEW3D_PT_enfilade_exchange(_Tab, bpy.types.Panel):
    bl_label = "Exchange"
    bl_parent_id = "VIEW3D_PT_enfilade"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        column = self.layout.column(align=True)
        column.operator("enfilade.export_scene", icon="EXPORT")
        column.operator("enfilade.write_indoorgml", icon="EXPORT")
        column.operator("enfilade.write_ifc", icon="EXPORT")
        self.layout.operator("enfilade.import_cells", icon="IMPORT")


class VIEW3D_PT_enfilade_mark(_Tab, bpy.types.Panel):
    bl_label = "Mark by Hand"
    bl_parent_id = "VIEW3D_PT_enfilade"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        grid = self.layout.grid_flow(columns=2, even_columns=True, align=True)
        for role in ("room", "exterior", "door", "window", "hole", "virtual", "ignore", "none"):
            grid.operator("enfilade.mark", text=role.capitalize() if role != "none" else "No Mark").role = role
        row = self.layout.row(align=True)
        row.operator("enfilade.check_marks", icon="VIEWZOOM")
        row.operator("enfilade.fix_marks", icon="MODIFIER", text="Mend All").name = ""
        if repair.mended_from:
            left = len(repair.offered)
            self.layout.label(text=f"{left} to mend" + (f" (was {repair.mended_from})" if repair.mended_from != left else ""))
        for fix in repair.offered[:12]:
            box = self.layout.box().column(align=True)
            _paragraph(box, fix.reason, context, 16)
            op = box.operator("enfilade.fix_marks", text=fix.remedy)
            op.name, op.kinds = fix.name, {fix.kind}
        if len(repair.offered) > 12:
            self.layout.label(text=f"and {len(repair.offered) - 12} more")


def _named(layout, text: str):
    """A row with its name before it; what comes back takes the rest."""
    split = layout.split(factor=0.33, align=True)
    split.label(text=text)
    return split


def _figures(layout, figures: list[tuple[str, str]]) -> None:
    split = layout.split(factor=0.45)
    left, right = split.column(align=True), split.column(align=True)
    for name, value in figures:
        left.label(text=name)
        right.label(text=value)


def _note(layout, text: str, icon: str, context) -> None:
    row = layout.row()
    row.label(text="", icon=icon)
    _paragraph(row.column(align=True), text, context, 36)


def _paragraph(layout, text: str, context, taken: int = 4) -> None:
    """Wrapped to the sidebar's width, by the width that its font gives the words. taken: pixels of it that are others'
    (margins, icons), before the interface is scaled."""
    scale = context.preferences.system.ui_scale if context.preferences else 1.0
    room = (context.region.width if context.region else 260) - (taken + compat.SIDEBAR_MARGINS) * scale
    style = context.preferences.ui_styles[0].widget if context.preferences else None
    blf.size(0, (style.points if style else 11) * scale)
    line = ""
    for word in text.split():
        longer = f"{line} {word}".strip()
        if line and blf.dimensions(0, longer)[0] > room:
            layout.label(text=line)
            longer = word
        line = longer
    layout.label(text=line)


CLASSES = (
    VIEW3D_PT_enfilade,
    VIEW3D_PT_enfilade_found,
    VIEW3D_PT_enfilade_seen,
    VIEW3D_PT_enfilade_problems,
    VIEW3D_PT_enfilade_cull,
    VIEW3D_PT_enfilade_show,
    VIEW3D_PT_enfilade_openings,
    VIEW3D_PT_enfilade_exchange,
    VIEW3D_PT_enfilade_mark,
)
_missing = False
register, unregister = registration(CLASSES, panel_data.forget)


def register_missing() -> None:
    global _missing
    bpy.utils.register_class(VIEW3D_PT_enfilade_missing)
    _missing = True


def unregister_missing() -> None:
    global _missing
    if _missing:
        bpy.utils.unregister_class(VIEW3D_PT_enfilade_missing)
        _missing = False

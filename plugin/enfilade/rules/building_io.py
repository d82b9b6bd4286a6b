# SPDX-License-Identifier: GPL-3.0-or-later
"""Rooms and openings of a Building as JSON, so that a saved .blend knows what an IFC file said without reading it again.

Objects, lights and cameras are not kept: they are read from the scene each time, since they move.
"""

from __future__ import annotations

import json

import numpy as np

from .building import Building, Opening, Problem, Room

FORMAT, VERSION = "enfilade-building", 1


def _list(array: np.ndarray | None) -> list | None:
    return None if array is None else np.asarray(array, dtype=np.float64).tolist()


def _array(value: list | None) -> np.ndarray | None:
    return None if value is None else np.asarray(value, dtype=np.float64).reshape(-1, 3)


def to_json(building: Building) -> str:
    """One line of JSON; floats round-trip exactly."""
    return json.dumps(
        {
            "format": FORMAT,
            "version": VERSION,
            "source": building.source,
            "rooms": [
                {
                    "name": r.name,
                    "kind": r.kind,
                    "storey": r.storey,
                    "source_id": r.source_id,
                    "long_name": r.long_name,
                    "top": None if np.isinf(r.top) else float(r.top),
                    "vertices": _list(r.vertices),
                    "faces": None if r.faces is None else [[int(i) for i in f] for f in r.faces],
                }
                for r in building.rooms
            ],
            "openings": [
                {
                    "name": o.name,
                    "kind": o.kind,
                    "state": o.state,
                    "source_id": o.source_id,
                    "rooms": None if o.rooms is None else [int(i) for i in o.rooms],
                    "body": _list(o.body),
                    "ends": None if o.ends is None else [_list(e) for e in o.ends],
                    "polygon": _list(o.polygon),
                    "members": [int(i) for i in o.members],
                }
                for o in building.openings
            ],
            "storeys": [[name, float(z)] for name, z in building.storeys],
            "problems": [
                {
                    "severity": p.severity,
                    "code": p.code,
                    "message": p.message,
                    "names": list(p.names),
                    "position": None if p.position is None else [float(x) for x in p.position],
                    "remedy": p.remedy,
                }
                for p in building.problems
            ],
        },
        ensure_ascii=False,
    )


def from_json(text: str) -> Building:
    """ValueError, with the reason, for anything that isn't such a building."""
    try:
        data = json.loads(text)
        if not isinstance(data, dict) or data.get("format") != FORMAT:
            raise ValueError("it isn't marked as an enfilade building")
        if data["version"] > VERSION:
            raise ValueError(f"version {data['version']} is newer than this Enfilade knows ({VERSION})")
        out = Building(source=str(data["source"]))
        for r in data["rooms"]:
            top = r.get("top")
            out.rooms.append(
                Room(r["name"], r["kind"], r["storey"], r["source_id"], _array(r["vertices"]), r["faces"], r["long_name"],
                     np.inf if top is None else float(top))
            )  # fmt: skip
        for o in data["openings"]:
            rooms = o["rooms"]
            if rooms is not None:
                rooms = (int(rooms[0]), int(rooms[1]))
                if not all(0 <= i < len(out.rooms) for i in rooms):
                    raise ValueError(f"opening {o['name']} names room {max(rooms)} of {len(out.rooms)}")
            ends = o["ends"]
            out.openings.append(
                Opening(
                    o["name"], o["kind"], o["state"], o["source_id"], rooms, _array(o["body"]),
                    None if ends is None else (_array(ends[0]), _array(ends[1])), _array(o["polygon"]),
                    tuple(int(i) for i in o.get("members", ())),
                )
            )
        if not all(0 <= i < len(out.openings) for o in out.openings for i in o.members):
            raise ValueError(f"an opening is the air of others beyond the {len(out.openings)} there are")
        out.storeys = [(str(name), float(z)) for name, z in data["storeys"]]
        for p in data["problems"]:
            position = None if p["position"] is None else tuple(float(x) for x in p["position"])
            out.problems.append(Problem(p["severity"], p["code"], p["message"], p["names"], position, p["remedy"]))
        return out
    except (KeyError, TypeError, IndexError) as error:
        raise ValueError(f"the stored building is damaged: {error!r}") from error

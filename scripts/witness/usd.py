#!/usr/bin/env python3
"""Opens an exported scene.usda with OpenUSD, checks it and prints its contents.

    pip install usd-core
    pelage export scenes/witness.toml --to usd -o exported
    scripts/witness/usd.py exported/scene.usda

Exit code 1 if OpenUSD's checker reports an error or a prim's arrays do not match in size.
"""

import sys

from pxr import Usd, UsdGeom, UsdLux, UsdUtils


def check(path, stage):
    """The messages of OpenUSD's own checks."""
    if hasattr(UsdUtils, "ComplianceChecker"):
        checker = UsdUtils.ComplianceChecker()
        checker.CheckCompliance(path)
        return checker.GetErrors() + checker.GetFailedChecks()
    # Since OpenUSD 26 there are validators in its place.
    from pxr import UsdValidation

    validators = UsdValidation.ValidationRegistry().GetOrLoadAllValidators()
    return [f"{e.GetName()}: {e.GetMessage()}" for e in UsdValidation.ValidationContext(validators).Validate(stage)]


def main():
    path = sys.argv[1]
    stage = Usd.Stage.Open(path)
    complaints = check(path, stage)
    print(f"{UsdGeom.GetStageMetersPerUnit(stage)} m a unit, {UsdGeom.GetStageUpAxis(stage)} up")
    for prim in stage.Traverse():
        line = f"{prim.GetPath()}: {prim.GetTypeName()}"
        if prim.IsA(UsdGeom.BasisCurves):
            curves = UsdGeom.BasisCurves(prim)
            counts, points, widths = (a.Get() for a in (curves.GetCurveVertexCountsAttr(), curves.GetPointsAttr(), curves.GetWidthsAttr()))
            line += f", {len(counts)} curves, {len(points)} points"
            if not sum(counts) == len(points) == len(widths):
                complaints.append(f"{prim.GetPath()}: {sum(counts)} vertices, {len(points)} points, {len(widths)} widths")
        elif prim.IsA(UsdGeom.Mesh):
            mesh = UsdGeom.Mesh(prim)
            line += f", {len(mesh.GetFaceVertexCountsAttr().Get())} faces"
            valid, why = UsdGeom.Mesh.ValidateTopology(
                mesh.GetFaceVertexIndicesAttr().Get(), mesh.GetFaceVertexCountsAttr().Get(), len(mesh.GetPointsAttr().Get())
            )
            if not valid:
                complaints.append(f"{prim.GetPath()}: {why}")
        elif prim.IsA(UsdGeom.Camera):
            view = UsdGeom.Camera(prim).GetCamera()
            line += f", field of view {view.GetFieldOfView(view.FOVVertical):.4f} degrees"
        elif prim.HasAPI(UsdLux.LightAPI):
            light = UsdLux.LightAPI(prim)
            line += f", {light.GetIntensityAttr().Get():g} x {light.GetColorAttr().Get()}"
        print(line)
    if complaints:
        sys.exit("\n".join(complaints))


if __name__ == "__main__":
    main()

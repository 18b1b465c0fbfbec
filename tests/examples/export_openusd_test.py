"""Splats as OpenUSD, read by its own library: export_openusd_test.py SIMULI EXAMPLES WORK"""
import pathlib
import sys

import numpy as np
from export_scene import AT_S, compare, particles, run, scene
from pxr import Usd, UsdGeom, UsdValidation, UsdVol

simuli, work = sys.argv[1], pathlib.Path(sys.argv[3])
drive = scene(simuli, work)
for name in ("a.ply", "a.usda", "a.usdz"):
    run(simuli, "export", drive, "--at", AT_S, "-o", work / name)
p = particles(work / "a.ply")
for name in ("a.usda", "a.usdz"):
    stage = Usd.Stage.Open(str(work / name))
    prim = stage.GetDefaultPrim()
    splats = UsdVol.ParticleField3DGaussianSplat(prim)
    assert splats and prim.GetTypeName() == "ParticleField3DGaussianSplat"
    assert UsdGeom.GetStageUpAxis(stage) == UsdGeom.Tokens.z and UsdGeom.GetStageMetersPerUnit(stage) == 1
    known = prim.GetPrimDefinition()
    for attribute in prim.GetAuthoredAttributes():
        schema = known.GetAttributeDefinition(attribute.GetName())
        assert schema and schema.GetTypeName() == attribute.GetTypeName(), attribute
        assert schema.GetVariability() == attribute.GetVariability(), attribute
    assert Usd.ColorSpaceAPI(prim).GetColorSpaceNameAttr().Get() == "srgb_rec709_scene"
    degree = prim.GetAttribute("radiance:sphericalHarmonicsDegree").Get()
    sh = np.array(prim.GetAttribute("radiance:sphericalHarmonicsCoefficients").Get())
    quaternions = prim.GetAttribute("orientations").Get()
    wxyz = np.array([[q.real, *q.imaginary] for q in quaternions])
    position = np.array(prim.GetAttribute("positions").Get())
    compare(p, np.eye(3), position, wxyz, np.array(prim.GetAttribute("scales").Get()),
            np.array(prim.GetAttribute("opacities").Get()), sh.reshape(len(position), (degree + 1) ** 2, 3))
    least, most = prim.GetAttribute("extent").Get()
    assert (np.array(least) < position.min(0)).all() and (np.array(most) > position.max(0)).all()
    validators = UsdValidation.ValidationRegistry().GetOrLoadAllValidators()
    errors = UsdValidation.ValidationContext(validators).Validate(stage)
    assert not errors, [(e.GetName(), e.GetMessage()) for e in errors]
print(len(p["x"]), "particles in OpenUSD", Usd.GetVersion())

"""Validates MaterialX documents or USD layers with their own libraries: documents.py mtlx|usda FILES."""

import os
import sys


def materialx(name):
    import MaterialX as mx

    document, library = mx.createDocument(), mx.createDocument()
    mx.loadLibraries(mx.getDefaultDataLibraryFolders(), mx.getDefaultDataSearchPath(), library)
    mx.readFromXmlFile(document, name)
    document.setDataLibrary(library)
    valid, message = document.validate()
    if not valid:
        return message
    missing = [
        f"{node.getName()} has no definition"
        for graph in [document, *document.getNodeGraphs()]
        for node in graph.getNodes()
        if node.getNodeDef() is None
    ]
    return "; ".join(missing)


def usd(name):
    from pxr import Usd, UsdShade

    stage = Usd.Stage.Open(name)
    if not stage or not UsdShade.Material(stage.GetDefaultPrim()).ComputeSurfaceSource()[0]:
        return "no surface"
    folder = os.path.dirname(name)
    for prim in stage.Traverse():
        shader = UsdShade.Shader(prim)
        file = shader.GetInput("file") if shader else None
        if file and not os.path.exists(os.path.join(folder, file.Get().path)):
            return f"{file.Get().path} is missing"
    return "; ".join(usd_problems(stage, name))


def usd_problems(stage, name):
    from pxr import UsdUtils

    if hasattr(UsdUtils, "ComplianceChecker"):
        checker = UsdUtils.ComplianceChecker(arkit=False, skipARKitRootLayerCheck=True)
        checker.CheckCompliance(name)
        return checker.GetErrors() + checker.GetFailedChecks()
    from pxr import UsdValidation

    validators = UsdValidation.ValidationRegistry().GetOrLoadAllValidators()
    found = UsdValidation.ValidationContext(validators).Validate(stage)
    return [error.GetErrorAsString() for error in found]


check = {"mtlx": materialx, "usda": usd}[sys.argv[1]]
problems = [(name, check(name)) for name in sys.argv[2:]]
for name, problem in problems:
    print(f"{'FAILED' if problem else 'ok'} {name}{': ' + problem if problem else ''}")
sys.exit(any(problem for _, problem in problems) or not problems)

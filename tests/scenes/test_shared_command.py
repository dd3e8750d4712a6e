#!/usr/bin/env python3
"""Every file under shared/gltf through the command: test_shared_command.py HPRAD SHARED.

Those of real/ are solved, as they are (most have no light), with every surface made a lamp, and under a white sky,
where the mean of what their surfaces send to the camera is compared with path tracing, and at the default settings
picture with picture in blocks; those of broken/ end with exit code 3 and a message that names file and fault, or are solved where glTF allows it. Skipped without
that folder.
"""
import json
import math
import os
import struct
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "support"))
import exr  # noqa: E402
import z_test  # noqa: E402
from cli_support import Command  # noqa: E402
from tap import check, done  # noqa: E402

COARSE = ("--order", "0", "--subdivide", "0")
SMALL = ("--size", "32x24", "--samples", "1")

# below gltf/: a text of the message that refuses it
REFUSED = {
    "real/DenseSphere.glb": "KHR_draco_mesh_compression",
    "real/many-cubes.gltf": "many-cubes.bin' cannot be read",  # which is not among the shared files
    "broken/BoxWithInfinites-glTF-Binary/BoxWithInfinites.glb": "-inf",
    "broken/IncorrectVertexArrays/Cube.gltf": "bufferView 2 ends 422 bytes past its buffer",
    "broken/IndexOutOfRange/AllIndicesOutOfRange.gltf": "there are 24 vertices",
    "broken/IndexOutOfRange/IndexOutOfRange.gltf": "there are 24 vertices",
    "broken/MissingBin/BoxTextured.gltf": "BoxTextured0.bin' cannot be read",
    "broken/RecursiveNodes/RecursiveNodes.gltf": "cycle",
    "broken/SchemaFailures/sceneWrongType.gltf": "not \"hello\"",
    "broken/TestNoRootNode/NoScene.gltf": "scene must be an index into scenes",
    "broken/draco-unsupported/2CylinderEngine.gltf": "KHR_draco_mesh_compression",
    "broken/issue_3269/texcoord_crash.gltf": "no TEXCOORD_0",
    "broken/wrongTypes/badArray.gltf": "primitives must be an array",
    "broken/wrongTypes/badExtension.gltf": "KHR_texture_transform must be an object",
    "broken/wrongTypes/badNumber.gltf": "normalTexture",
    "broken/wrongTypes/badObject.gltf": "pbrMetallicRoughness must be an object",
    "broken/wrongTypes/badString.gltf": "name must be a string",
    "broken/wrongTypes/badUint.gltf": "baseColorTexture.index must be an index",
}
# Only their normals are wrong, which hprad does not use; and a scene may be without nodes.
BROKEN_BUT_SOLVED = {"broken/BoxBadNormals-glTF-Binary/BoxBadNormals.glb",
                     "broken/TestNoRootNode/SceneWithoutNodes.gltf"}
TOO_SLOW_AT_THE_DEFAULT = {"chr_knight.glb"}  # 730 patches, 10 s
TOO_LARGE_TO_LIGHT = {"2CylinderEngine.glb", "ShapeCollection.glb"}  # 121,496 and 3,501 patches


def scenes(root):
    for kind in ("broken", "real"):
        for folder, folders, files in os.walk(os.path.join(root, kind)):
            folders.sort()
            for name in sorted(files):
                if name.endswith((".gltf", ".glb")):
                    yield os.path.relpath(os.path.join(folder, name), root)


def wrong(command, result, code, texts, outputs):
    """What differs from: this exit code, these texts on stderr, these files and no others in the folder."""
    told = f"exit code {result.returncode}, stderr {result.stderr!r}"
    if result.returncode != code:
        yield f"expected exit code {code}: {told}"
    for text in texts:
        if text not in result.stderr:
            yield f"stderr lacks {text!r}: {told}"
    found = command.listing()
    if found != sorted(outputs):
        yield f"expected the files {sorted(outputs)}, found {found}; {told}"
    for name in found:
        os.remove(os.path.join(command.folder, name))


def check_as_it_is(command, root, below):
    path = os.path.join(root, below)
    solve = command("solve", path, *COARSE, "-o", "x.glb")
    if below in REFUSED:
        texts = [path + ": ", REFUSED[below]]
        check(f"refused: solve {below}", wrong(command, solve, 3, texts, []))
        picture = command(path, *COARSE, *SMALL, "-o", "x.exr")
        check(f"refused: {below}", wrong(command, picture, 3, texts, []))
    elif below in BROKEN_BUT_SOLVED or below.startswith("real/"):
        check(f"solve {below}", wrong(command, solve, 0, [], ["x.glb"]))
        picture = command(path, *COARSE, *SMALL, "--camera", "0", "-o", "x.exr")
        check(f"in one go {below}", wrong(command, picture, 0, [], ["x.exr"]))
    else:
        check(f"{below} is in a table", False)


def make_lamps(gltf):
    materials = gltf.setdefault("materials", [])
    for material in materials:
        material.pop("emissiveTexture", None)
        material["emissiveFactor"] = [1, .5, .25]
    materials.append({"emissiveFactor": [1, .5, .25]})
    for mesh in gltf["meshes"]:
        for primitive in mesh["primitives"]:
            primitive.setdefault("material", len(materials) - 1)


def write_lit(source, folder):
    """A copy beside links to the source's neighbours, in which every surface is a lamp; its path."""
    for name in os.listdir(os.path.dirname(source)):
        if name != os.path.basename(source):
            os.symlink(os.path.join(os.path.dirname(source), name), os.path.join(folder, name))
    target = os.path.join(folder, os.path.basename(source))
    with open(source, "rb") as file:
        data = file.read()
    binary = data[:4] == b"glTF"
    length = struct.unpack_from("<I", data, 12)[0] if binary else 0
    gltf = json.loads(data[20:20 + length] if binary else data)
    make_lamps(gltf)
    text = json.dumps(gltf).encode()
    if binary:
        text += b" " * (-len(text) % 4)
        rest = data[20 + length:]
        text = struct.pack("<4sIIII", b"glTF", 2, 20 + len(text) + len(rest), len(text), 0x4E4F534A) + text + rest
    with open(target, "wb") as file:
        file.write(text)
    return target


def insane(report):
    """Energy terms that cannot be: not finite, negative, or more absorbed, lost and escaped than the sampled
    terms' noise allows."""
    for item in report["energy"]:
        terms = [item[key] for key in ("emitted", "absorbed", "lost_on_backs", "escaped")]
        if None in terms or not all(math.isfinite(x) and x >= 0 for x in terms):
            yield f"energy {item}"
        elif abs(terms[0] - sum(terms[1:])) > .05 * terms[0]:
            yield f"the balance is off by more than 5%: {item}"


def check_lit(command, root, below):
    with tempfile.TemporaryDirectory() as folder:
        path = write_lit(os.path.join(root, below), folder)
        result = command("solve", path, *COARSE, "-o", "x.glb", "--report", "x.json")
        report = {"energy": []}
        if result.returncode == 0:
            with open(os.path.join(command.folder, "x.json"), encoding="utf-8") as file:
                report = json.load(file)
        check(f"all lamps: solve {below}",
              [*wrong(command, result, 0, [], ["x.glb", "x.json"]), *insane(report)])


def surface_means(picture):
    """Per channel: the mean radiance of what is covered by surfaces, the sky (radiance 1) taken out."""
    covered = picture.channels["A"]
    return [math.fsum(value - (1 - a) for value, a in zip(picture.channels[c], covered)) / math.fsum(covered)
            for c in "RGB"]


def sky_problems(command):
    """x.exr against reference.exr. Their surfaces' means differ by the noise of 64 paths per pixel and by what one
    constant per patch does to the indirect light: 0.8 % at most, seen in the knight."""
    coarse = .02
    seen, reference = (exr.read(os.path.join(command.folder, name)) for name in ("x.exr", "reference.exr"))
    if not any(reference.channels["A"]):
        if any(seen.channels["A"]) or any(value != 1 for c in "RGB" for value in seen.channels[c]):
            yield "nothing is there, but the picture is not all sky"
        return
    for c, mean, true in zip("RGB", surface_means(seen), surface_means(reference)):
        error = math.sqrt(math.fsum(reference.channels["variance." + c])) / math.fsum(reference.channels["A"])
        if not abs(mean - true) <= coarse * true + 4 * error:
            yield f"{c}: mean radiance of the surfaces {mean:.5f}, by path tracing {true:.5f} +- {error:.5f}"
    if not max(surface_means(seen)) > 0:
        yield "black"


def check_sky(command, root, below):
    path, options = os.path.join(root, below), ("--environment", "1", "--camera", "0", "--size", "48x36")
    result = command(path, *COARSE, *options, "-o", "x.exr", "--report", "x.json")
    reference = command("reference", path, *options, "-o", "reference.exr")
    check(f"under a white sky: {below}",
          [*(sky_problems(command) if result.returncode == reference.returncode == 0 else []),
           *wrong(command, result, 0, [], ["x.exr", "x.json", "reference.exr"])])


def check_default(command, root, below):
    """The picture that a user gets, block by block against path tracing."""
    path, options = os.path.join(root, below), ("--environment", "1", "--camera", "0", "--size", "64x64")
    result = command(path, *options, "--samples", "64", "-o", "x.exr")
    reference = command("reference", path, *options, "-o", "reference.exr")
    verdict = []
    if result.returncode == reference.returncode == 0:
        verdict = z_test.compare(*(os.path.join(command.folder, name) for name in ("reference.exr", "x.exr")), .02).problems
    check(f"under a white sky, as it comes: {below}", [*verdict, *wrong(command, result, 0, [], ["x.exr", "reference.exr"])])


def main():
    root = os.path.join(os.environ.get("HPRAD_SHARED", sys.argv[2]), "gltf")
    if not os.path.isdir(root):
        print("1..0 # SKIP no folder " + root)
        return 0
    with tempfile.TemporaryDirectory() as folder:
        command = Command(sys.argv[1], folder)
        for below in scenes(root):
            check_as_it_is(command, root, below)
            if below.startswith("real/") and below not in REFUSED and os.path.basename(below) not in TOO_LARGE_TO_LIGHT:
                check_lit(command, root, below)
                check_sky(command, root, below)
                if os.path.basename(below) not in TOO_SLOW_AT_THE_DEFAULT:
                    check_default(command, root, below)
    return done()


sys.exit(main())

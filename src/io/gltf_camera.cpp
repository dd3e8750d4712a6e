/* Cameras, posed by their nodes. */
#include "io/gltf.hpp"

#include <cmath>

namespace gltf
{

namespace
{

/* False for a vector that has no direction. */
bool normalize(double v[3])
{
    double length = std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    for (int a = 0; a < 3; a++)
        v[a] /= length;
    return std::isfinite(v[0] + v[1] + v[2]);
}

void cross(const double a[3], const double b[3], double out[3])
{
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

/* glTF: a camera looks along its node's -z with +y up; scale is ignored, and a mirroring node does not mirror
 * the picture. The view axis is kept exactly, up is made orthogonal to it, right completes the frame. */
bool set_pose(const matrix &world, hpr_camera &camera)
{
    for (int a = 0; a < 3; a++) {
        camera.origin[a] = world.m[a][3];
        camera.up[a] = world.m[a][1];
        camera.backward[a] = world.m[a][2];
    }
    bool good = normalize(camera.up) && normalize(camera.backward);
    cross(camera.up, camera.backward, camera.right);
    good = good && normalize(camera.right);
    cross(camera.backward, camera.right, camera.up);
    return good;
}

void set_lens(const document &doc, const std::string &what, const tinygltf::Camera &from, hpr_camera &camera)
{
    bool perspective = from.type == "perspective";
    if (perspective) {
        camera.kind = HPR_CAMERA_PERSPECTIVE;
        camera.yfov_rad = from.perspective.yfov;
        camera.aspect = from.perspective.aspectRatio; /* 0 where the file gives none */
        camera.znear = from.perspective.znear;
        camera.zfar = from.perspective.zfar > 0 ? from.perspective.zfar : HUGE_VAL;
    } else {
        /* A negative xmag or ymag mirrors the picture in some readers; glTF discourages it. */
        camera.kind = HPR_CAMERA_ORTHOGRAPHIC;
        camera.xmag = from.orthographic.xmag;
        camera.ymag = from.orthographic.ymag;
        camera.znear = from.orthographic.znear;
        camera.zfar = from.orthographic.zfar;
    }
    if (!(camera.zfar > camera.znear))
        fail(doc, HPR_ERR_FORMAT, "%s: zfar %g is not beyond znear %g", what.c_str(), camera.zfar,
             camera.znear);
}

} // namespace

void add_cameras(const document &doc, const std::vector<placed_node> &nodes, hpr_scene *scene)
{
    for (const placed_node &place : nodes) {
        const tinygltf::Node &node = doc.model.nodes[place.node];
        if (node.camera < 0)
            continue;
        auto index = static_cast<size_t>(node.camera);
        const tinygltf::Camera &from = doc.model.cameras[index];
        std::string what = label("camera", index, from.name);
        hpr_camera camera = {};
        set_lens(doc, what, from, camera);
        if (!set_pose(place.world, camera))
            fail(doc, HPR_ERR_FORMAT, "%s: the matrix of its %s gives no view direction", what.c_str(),
                 label("node", place.node, node.name).c_str());
        /* The node's name comes first: one camera may stand at several nodes. */
        std::string name = one_line(node.name.empty() ? from.name : node.name);
        camera.name = name.data();
        check(hpr_scene_add_camera(scene, &camera));
    }
}

} // namespace gltf

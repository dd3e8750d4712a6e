/* The node graph: which nodes belong to the scene, and where they stand. */
#include "io/gltf.hpp"

#include <cmath>

namespace gltf
{

namespace
{

const int no_parent = -1;

std::string node_label(const document &doc, int node)
{
    auto i = static_cast<size_t>(node);
    return label("node", i, doc.model.nodes[i].name);
}

matrix identity()
{
    return {{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}};
}

matrix multiply(const matrix &a, const matrix &b)
{
    matrix out;
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 4; j++) {
            out.m[i][j] = j == 3 ? a.m[i][3] : 0;
            for (int k = 0; k < 3; k++)
                out.m[i][j] += a.m[i][k] * b.m[k][j];
        }
    }
    return out;
}

/* glTF asks for unit quaternions; what float rounding left of one is made exact. */
void rotate(const document &doc, int node, const std::vector<double> &q, matrix &out)
{
    const double rounding = 1e-2;
    double norm = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    if (!(std::fabs(norm - 1) <= rounding))
        fail(doc, HPR_ERR_FORMAT, "%s: the rotation's quaternion has length %g, not 1",
             node_label(doc, node).c_str(), norm);
    double x = q[0] / norm, y = q[1] / norm, z = q[2] / norm, w = q[3] / norm;
    double r[3][3] = {{1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)},
                      {2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)},
                      {2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)}};
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++)
            out.m[i][j] = r[i][j];
    }
}

matrix local_matrix(const document &doc, int index)
{
    const tinygltf::Node &node = doc.model.nodes[static_cast<size_t>(index)];
    matrix out = identity();
    if (!node.matrix.empty()) {
        const std::vector<double> &m = node.matrix;
        if (m[3] != 0 || m[7] != 0 || m[11] != 0 || m[15] != 1)
            fail(doc, HPR_ERR_FORMAT, "%s: the last row of its matrix is %g %g %g %g, not 0 0 0 1",
                 node_label(doc, index).c_str(), m[3], m[7], m[11], m[15]);
        for (size_t i = 0; i < 3; i++) {
            for (size_t j = 0; j < 4; j++)
                out.m[i][j] = m[4 * j + i];
        }
        return out;
    }
    if (!node.rotation.empty())
        rotate(doc, index, node.rotation, out);
    for (size_t i = 0; i < 3; i++) {
        for (size_t j = 0; !node.scale.empty() && j < 3; j++)
            out.m[i][j] *= node.scale[j];
        if (!node.translation.empty())
            out.m[i][3] = node.translation[i];
    }
    return out;
}

/* Parent of every node. glTF wants a forest: a node with two parents or below itself is refused. */
std::vector<int> find_parents(const document &doc)
{
    size_t count = doc.model.nodes.size(), reached = 0;
    std::vector<int> parent(count, no_parent), stack;
    for (size_t i = 0; i < count; i++) {
        for (int child : doc.model.nodes[i].children) {
            int &p = parent[static_cast<size_t>(child)];
            if (p != no_parent)
                fail(doc, HPR_ERR_FORMAT, "%s is a child of node %d and of node %zu; a node has one parent",
                     node_label(doc, child).c_str(), p, i);
            p = static_cast<int>(i);
        }
    }
    std::vector<bool> seen(count, false);
    for (size_t i = 0; i < count; i++) {
        if (parent[i] == no_parent)
            stack.push_back(static_cast<int>(i));
    }
    while (!stack.empty()) {
        int node = stack.back();
        stack.pop_back();
        seen[static_cast<size_t>(node)] = true;
        reached++;
        for (int child : doc.model.nodes[static_cast<size_t>(node)].children)
            stack.push_back(child);
    }
    for (size_t i = 0; reached < count && i < count; i++) {
        if (!seen[i])
            fail(doc, HPR_ERR_FORMAT, "%s is among its own ancestors: the node graph has a cycle",
                 node_label(doc, static_cast<int>(i)).c_str());
    }
    return parent;
}

std::vector<int> scene_roots(const document &doc, const hpr_read_options &options,
                             const std::vector<int> &parent)
{
    int scene_count = static_cast<int>(doc.model.scenes.size()), chosen = options.scene_index;
    if (chosen >= scene_count)
        fail(doc, HPR_ERR_ARG, "scene %d is asked for, but the file has %d, counted from 0", chosen,
             scene_count);
    if (chosen < 0)
        chosen = doc.model.defaultScene >= 0 ? doc.model.defaultScene : 0;
    std::vector<int> roots;
    if (scene_count == 0) {
        for (size_t i = 0; i < parent.size(); i++) {
            if (parent[i] == no_parent)
                roots.push_back(static_cast<int>(i));
        }
        return roots;
    }
    std::vector<bool> listed(parent.size(), false);
    const tinygltf::Scene &scene = doc.model.scenes[static_cast<size_t>(chosen)];
    for (int node : scene.nodes) {
        auto i = static_cast<size_t>(node);
        if (listed[i] || parent[i] != no_parent)
            fail(doc, HPR_ERR_FORMAT, "%s: %s is %s",
                 label("scene", static_cast<size_t>(chosen), scene.name).c_str(),
                 node_label(doc, node).c_str(), listed[i] ? "listed twice" : "not a root node");
        listed[i] = true;
    }
    return scene.nodes;
}

} // namespace

double determinant(const matrix &a)
{
    return a.m[0][0] * (a.m[1][1] * a.m[2][2] - a.m[1][2] * a.m[2][1]) -
           a.m[0][1] * (a.m[1][0] * a.m[2][2] - a.m[1][2] * a.m[2][0]) +
           a.m[0][2] * (a.m[1][0] * a.m[2][1] - a.m[1][1] * a.m[2][0]);
}

std::vector<placed_node> place_nodes(const document &doc, const hpr_read_options &options)
{
    std::vector<int> parent = find_parents(doc), stack = scene_roots(doc, options, parent);
    std::vector<matrix> world(parent.size());
    std::vector<bool> present(parent.size(), false);
    while (!stack.empty()) {
        int node = stack.back();
        stack.pop_back();
        auto i = static_cast<size_t>(node);
        bool root = parent[i] == no_parent;
        world[i] = local_matrix(doc, node);
        if (!root)
            world[i] = multiply(world[static_cast<size_t>(parent[i])], world[i]);
        present[i] = true;
        for (int child : doc.model.nodes[i].children)
            stack.push_back(child);
    }
    std::vector<placed_node> out;
    for (size_t i = 0; i < world.size(); i++) {
        if (present[i])
            out.push_back({static_cast<uint32_t>(i), world[i]});
    }
    return out;
}

} // namespace gltf

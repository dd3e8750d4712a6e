/* Primitives: triangles in the mesh's own frame, read once and placed by every node that uses them. */
#include "io/gltf.hpp"

#include <cmath>

namespace gltf
{

namespace
{

const double default_reflectance = 0.8; /* of a primitive without material */
const size_t cancel_interval = 256;     /* textured faces between two looks at the cancel flag */

struct primitive_data {
    bool skipped = false; /* points or lines */
    size_t vertex_count = 0;
    std::vector<double> position, uv, colour, reflectance, glow_uv, radiance; /* empty: none */
    std::vector<uint32_t> face; /* [faces][4], the fourth HPR_NONE */
};

struct reader {
    document &doc;
    texture_set &textures;
    const std::vector<material_use> &materials;
    size_t skipped = 0, incomplete = 0;
};

/* Which component types an attribute may have. */
struct attribute_rule {
    bool plain_integers;      /* without normalisation (KHR_mesh_quantization) */
    bool normalized_unsigned; /* as core glTF has for texture coordinates and colours */
    bool normalized_signed;
};

void check_attribute(const document &doc, const std::string &where, const char *name,
                     const tinygltf::Accessor &a, const attribute_rule &rule)
{
    bool is_unsigned = a.componentType == TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE ||
                       a.componentType == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT;
    bool is_signed =
        a.componentType == TINYGLTF_COMPONENT_TYPE_BYTE || a.componentType == TINYGLTF_COMPONENT_TYPE_SHORT;
    bool good = a.componentType == TINYGLTF_COMPONENT_TYPE_FLOAT;
    if (is_unsigned)
        good = a.normalized ? rule.normalized_unsigned : rule.plain_integers;
    if (is_signed)
        good = a.normalized ? rule.normalized_signed : rule.plain_integers;
    if (!good)
        fail(doc, HPR_ERR_FORMAT, "%s: %s has componentType %d, normalized %s; glTF does not allow it%s",
             where.c_str(), name, a.componentType, a.normalized ? "true" : "false",
             doc.quantized ? "" : " without KHR_mesh_quantization");
}

/* Accessor of an attribute, -1 if the primitive has none. */
int find_attribute(const tinygltf::Primitive &primitive, const std::string &name)
{
    auto found = primitive.attributes.find(name);
    return found == primitive.attributes.end() ? -1 : found->second;
}

void check_shape(const document &doc, const std::string &where, const char *name, const tinygltf::Accessor &a,
                 int type, size_t count)
{
    if (a.type != type)
        fail(doc, HPR_ERR_FORMAT, "%s: %s has %d components, not %d", where.c_str(), name,
             tinygltf::GetNumComponentsInType(static_cast<uint32_t>(a.type)),
             tinygltf::GetNumComponentsInType(static_cast<uint32_t>(type)));
    if (a.count != count)
        fail(doc, HPR_ERR_FORMAT, "%s: %s has %zu elements, POSITION %zu", where.c_str(), name, a.count,
             count);
}

void read_positions(reader &r, const tinygltf::Primitive &primitive, const std::string &where,
                    primitive_data &out)
{
    int accessor = find_attribute(primitive, "POSITION");
    if (accessor < 0)
        fail(r.doc, HPR_ERR_FORMAT, "%s has no POSITION", where.c_str());
    const tinygltf::Accessor &a = r.doc.model.accessors[static_cast<size_t>(accessor)];
    bool q = r.doc.quantized;
    check_attribute(r.doc, where, "POSITION", a, {q, q, q});
    check_shape(r.doc, where, "POSITION", a, TINYGLTF_TYPE_VEC3, a.count);
    out.vertex_count = a.count;
    out.position = read_numbers(r.doc, accessor, 3);
}

void read_colours(reader &r, const tinygltf::Primitive &primitive, const std::string &where,
                  primitive_data &out)
{
    int accessor = find_attribute(primitive, "COLOR_0");
    if (accessor < 0)
        return;
    const tinygltf::Accessor &a = r.doc.model.accessors[static_cast<size_t>(accessor)];
    check_attribute(r.doc, where, "COLOR_0", a, {false, true, false});
    bool alpha = a.type == TINYGLTF_TYPE_VEC4; /* ignored */
    check_shape(r.doc, where, "COLOR_0", a, alpha ? TINYGLTF_TYPE_VEC4 : TINYGLTF_TYPE_VEC3,
                out.vertex_count);
    out.colour = read_numbers(r.doc, accessor, 3);
}

/* Texture coordinates as a texture is sampled with them: its transform included. */
std::vector<double> read_coordinates(reader &r, const tinygltf::Primitive &primitive,
                                     const std::string &where, const texture_use &use, const char *kind,
                                     size_t vertex_count)
{
    std::string name = print("TEXCOORD_%d", use.set);
    int accessor = find_attribute(primitive, name);
    if (accessor < 0)
        fail(r.doc, HPR_ERR_FORMAT, "%s has no %s, which the %s texture of material %d is laid on",
             where.c_str(), name.c_str(), kind, primitive.material);
    const tinygltf::Accessor &a = r.doc.model.accessors[static_cast<size_t>(accessor)];
    check_attribute(r.doc, where, name.c_str(), a, {r.doc.quantized, true, r.doc.quantized});
    check_shape(r.doc, where, name.c_str(), a, TINYGLTF_TYPE_VEC2, vertex_count);
    std::vector<double> uv = read_numbers(r.doc, accessor, 2);
    for (size_t i = 0; i < vertex_count; i++) {
        double u = uv[2 * i], v = uv[2 * i + 1];
        for (size_t k = 0; k < 2; k++)
            uv[2 * i + k] = use.offset[k] + use.matrix[k][0] * u + use.matrix[k][1] * v;
        if (!std::isfinite(uv[2 * i] + uv[2 * i + 1]))
            fail(r.doc, HPR_ERR_FORMAT, "%s: %s of vertex %zu is (%g, %g)", where.c_str(), name.c_str(), i, u,
                 v);
    }
    return uv;
}

void add_face(const std::vector<uint32_t> &index, size_t a, size_t b, size_t c, primitive_data &out)
{
    out.face.insert(out.face.end(), {index[a], index[b], index[c], HPR_NONE});
}

/* Triangles in the order and winding of glTF 2.0, 3.7.2.1. Corners that repeat within a strip or fan only
 * join its parts and make no face. */
void read_faces(reader &r, const tinygltf::Primitive &primitive, const std::string &where,
                primitive_data &out)
{
    std::vector<uint32_t> index;
    if (primitive.indices >= 0)
        index = read_indices(r.doc, primitive.indices, out.vertex_count, where);
    for (uint32_t i = 0; primitive.indices < 0 && i < out.vertex_count; i++)
        index.push_back(i);
    size_t count = index.size();
    if (primitive.mode == TINYGLTF_MODE_TRIANGLES) {
        r.incomplete += count % 3 != 0;
        for (size_t i = 0; i + 2 < count; i += 3)
            add_face(index, i, i + 1, i + 2, out);
        return;
    }
    bool strip = primitive.mode == TINYGLTF_MODE_TRIANGLE_STRIP;
    r.incomplete += count < 3;
    for (size_t i = 0; i + 2 < count; i++) {
        size_t a = strip ? i : i + 1, b = strip ? i + 1 + i % 2 : i + 2, c = strip ? i + 2 - i % 2 : 0;
        if (index[a] != index[b] && index[b] != index[c] && index[c] != index[a])
            add_face(index, a, b, c, out);
    }
}

/* Mean over a face of the texture times a colour, given at the corners. */
rgb average_texture(reader &r, texture &tex, const primitive_data &from, size_t f,
                    const std::vector<double> &at, const rgb corner[3])
{
    double uv[3][2];
    for (size_t k = 0; k < 3; k++) {
        for (size_t a = 0; a < 2; a++)
            uv[k][a] = at[2 * from.face[4 * f + k] + a];
    }
    hpr_count(r.doc.context, HPR_COUNT_TEXTURES, 1);
    if (f % cancel_interval == 0 && hpr_cancelled(r.doc.context))
        fail(r.doc, HPR_ERR_INTERRUPTED, "interrupted");
    return texture_triangle_mean(tex, uv, corner);
}

/* Mean of factor * colour * texture over each face. */
void average_reflectance(reader &r, const tinygltf::Primitive &primitive, primitive_data &out)
{
    rgb factor = {default_reflectance, default_reflectance, default_reflectance};
    texture *tex = nullptr;
    if (primitive.material >= 0) {
        const material_use &use = r.materials[static_cast<size_t>(primitive.material)];
        factor = use.reflectance;
        tex = use.base ? &r.textures.open(use.base->index) : nullptr;
    }
    for (size_t f = 0; f < out.face.size() / 4; f++) {
        rgb corner[3], mean = {0, 0, 0};
        for (size_t k = 0; k < 3; k++) {
            size_t v = out.face[4 * f + k];
            for (size_t c = 0; c < 3; c++) {
                corner[k][c] = factor[c] * (out.colour.empty() ? 1 : out.colour[3 * v + c]);
                mean[c] += corner[k][c] / 3;
            }
        }
        if (tex)
            mean = average_texture(r, *tex, out, f, out.uv, corner);
        out.reflectance.insert(out.reflectance.end(), mean.begin(), mean.end());
    }
}

/* Mean of factor * emissive texture over each face. */
void average_radiance(reader &r, const material_use &use, primitive_data &out)
{
    texture &tex = r.textures.open(use.glow->index);
    const rgb corner[3] = {use.radiance, use.radiance, use.radiance};
    for (size_t f = 0; f < out.face.size() / 4; f++) {
        rgb mean = average_texture(r, tex, out, f, out.glow_uv, corner);
        out.radiance.insert(out.radiance.end(), mean.begin(), mean.end());
    }
}

primitive_data read_primitive(reader &r, const tinygltf::Primitive &primitive, const std::string &where)
{
    primitive_data out;
    out.skipped = primitive.mode != TINYGLTF_MODE_TRIANGLES &&
                  primitive.mode != TINYGLTF_MODE_TRIANGLE_STRIP &&
                  primitive.mode != TINYGLTF_MODE_TRIANGLE_FAN;
    if (out.skipped) {
        r.skipped++;
        return out;
    }
    read_positions(r, primitive, where, out);
    read_colours(r, primitive, where, out);
    const material_use *use =
        primitive.material >= 0 ? &r.materials[static_cast<size_t>(primitive.material)] : nullptr;
    if (use && use->base)
        out.uv = read_coordinates(r, primitive, where, *use->base, "base colour", out.vertex_count);
    if (use && use->glow)
        out.glow_uv = read_coordinates(r, primitive, where, *use->glow, "emissive", out.vertex_count);
    read_faces(r, primitive, where, out);
    if (!out.uv.empty() || !out.colour.empty())
        average_reflectance(r, primitive, out);
    if (use && use->glow)
        average_radiance(r, *use, out);
    return out;
}

void place_primitive(const primitive_data &from, const matrix &world, hpr_mesh &mesh, hpr_scene *scene)
{
    std::vector<double> position(from.position.size());
    for (size_t v = 0; v < from.vertex_count; v++) {
        const double *p = &from.position[3 * v];
        for (size_t a = 0; a < 3; a++) {
            const double *row = world.m[a];
            position[3 * v + a] = row[0] * p[0] + row[1] * p[1] + row[2] * p[2] + row[3];
        }
    }
    std::vector<uint32_t> face = from.face;
    bool mirrored = determinant(world) < 0;
    for (size_t f = 0; mirrored && f < face.size(); f += 4)
        std::swap(face[f + 1], face[f + 2]);
    mesh.vertex_count = from.vertex_count;
    mesh.position = position.data();
    mesh.uv = from.uv.empty() ? nullptr : from.uv.data();
    mesh.colour = from.colour.empty() ? nullptr : from.colour.data();
    mesh.face_count = face.size() / 4;
    mesh.vertex = face.data();
    mesh.glow_uv = from.glow_uv.empty() ? nullptr : from.glow_uv.data();
    mesh.face_radiance = from.radiance.empty() ? nullptr : from.radiance.data();
    mesh.face_reflectance = from.reflectance.empty() ? nullptr : from.reflectance.data();
    check(hpr_scene_add_mesh(scene, &mesh));
}

std::vector<primitive_data> read_mesh(reader &r, size_t index)
{
    const tinygltf::Mesh &mesh = r.doc.model.meshes[index];
    std::vector<primitive_data> out;
    for (size_t p = 0; p < mesh.primitives.size(); p++)
        out.push_back(read_primitive(r, mesh.primitives[p],
                                     label("mesh", index, mesh.name) + print(", primitive %zu", p)));
    return out;
}

void set_textures(texture_set &textures, const material_use &use, hpr_scene *scene, hpr_mesh &mesh)
{
    std::optional<uint32_t> base, glow;
    if (use.base)
        base = textures.hand_on(use.base->index, scene);
    if (use.glow)
        glow = textures.hand_on(use.glow->index, scene);
    mesh.texture = base.value_or(HPR_NONE);
    mesh.factor = base ? use.reflectance.data() : nullptr;
    mesh.glow_texture = glow.value_or(HPR_NONE);
    mesh.glow_factor = glow ? use.radiance.data() : nullptr;
}

} // namespace

void add_meshes(document &doc, texture_set &textures, const std::vector<material_use> &materials,
                const std::vector<placed_node> &nodes, hpr_scene *scene)
{
    reader r = {doc, textures, materials};
    std::vector<std::vector<primitive_data>> cache(doc.model.meshes.size());
    for (const placed_node &place : nodes) {
        const tinygltf::Node &node = doc.model.nodes[place.node];
        if (node.mesh < 0)
            continue;
        if (hpr_cancelled(doc.context))
            fail(doc, HPR_ERR_INTERRUPTED, "interrupted");
        auto m = static_cast<size_t>(node.mesh);
        const tinygltf::Mesh &mesh = doc.model.meshes[m];
        if (cache[m].empty())
            cache[m] = read_mesh(r, m);
        std::string name = one_line(node.name.empty() ? mesh.name : node.name);
        for (size_t p = 0; p < cache[m].size(); p++) {
            if (cache[m][p].face.empty())
                continue;
            int material = mesh.primitives[p].material;
            hpr_mesh add = {};
            add.name = name.c_str();
            add.node = place.node;
            add.primitive = static_cast<uint32_t>(p);
            add.material = material < 0 ? HPR_NONE : static_cast<uint32_t>(material);
            if (material >= 0)
                set_textures(textures, materials[static_cast<size_t>(material)], scene, add);
            place_primitive(cache[m][p], place.world, add, scene);
        }
    }
    if (r.skipped)
        hpr_warn(doc.context, "%s: points and lines are left out (primitives: %zu)", doc.path.c_str(),
                 r.skipped);
    if (r.incomplete)
        hpr_warn(doc.context, "%s: incomplete triangles at the end are left out (primitives: %zu)",
                 doc.path.c_str(), r.incomplete);
}

} // namespace gltf

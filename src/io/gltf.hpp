/*
 * What the gltf_*.cpp files share. They read a glTF file in this order:
 *   document  bytes -> JSON -> checked against the schema -> tinygltf::Model
 *   accessor  buffers and views -> arrays of numbers, every span checked before it is touched
 *   texture   images -> the mean of a texture over a triangle, and its texels for the scene
 *   material, node, mesh -> the scene builder
 * Errors are thrown as gltf::fault and end in hpr_scene_read (gltf_read.cpp); no exception leaves these
 * files.
 */
#ifndef HPR_IO_GLTF_HPP
#define HPR_IO_GLTF_HPP

#include "scene/scene.h"

#include <cjson/cJSON.h>
#include <tiny_gltf.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace gltf
{

using bytes = std::vector<unsigned char>;
using rgb = std::array<double, 3>;

/* `text` is empty when the message stands on the context already. */
struct fault : std::exception {
    hpr_status status;
    std::string text;
    fault(hpr_status status, std::string text) : status(status), text(std::move(text)) {}
};

struct json_delete {
    void operator()(cJSON *json) const
    {
        cJSON_Delete(json);
    }
};

struct document {
    hpr_context *context = nullptr;
    std::string path; /* as the caller gave it; opens every message */
    bytes file;
    size_t chunk_offset = 0, chunk_bytes = 0; /* of the binary chunk of a .glb in `file`; 0: none */
    std::unique_ptr<cJSON, json_delete> json; /* checked against the schema */
    tinygltf::Model model;                    /* of the JSON without its buffers and images */
    std::vector<std::optional<bytes>> buffer; /* loaded when first read */
    bool quantized = false;                   /* KHR_mesh_quantization is in use */
};

std::string print(const char *format, ...) HPR_PRINTF(1, 2);
[[noreturn]] void fail(const document &doc, hpr_status status, const char *format, ...) HPR_PRINTF(3, 4);
/* Throws if a call of the C side failed; its message stands on the context. */
void check(hpr_status status);
/* "mesh 3 'Box'", or without the name if there is none. */
std::string label(const char *kind, size_t index, const std::string &name);
/* Line breaks and other control characters become blanks: a message is one line. */
std::string one_line(const std::string &text);

/* gltf_document.cpp */
void open_document(document &doc);
/* Whether an extension is listed in extensionsUsed. */
bool uses_extension(const document &doc, const char *name);
/* gltf_schema.cpp: types, ranges, required members and index ranges of everything that glTF 2.0 defines. */
void check_schema(const document &doc);
/* gltf_warning.cpp: names once each what the file asks for and hprad leaves out. */
void warn_ignored(const document &doc, const hpr_read_options &options);

/* gltf_uri.cpp: the bytes behind a URI, at most `limit` of them; `what` names its owner in messages. */
bytes load_uri(const document &doc, const char *uri, const std::string &what, size_t limit);
/* The whole file, at most `limit` bytes of it. */
bytes read_file(const document &doc, const std::string &path, const std::string &what, size_t limit);

/* gltf_accessor.cpp */
struct view {
    const unsigned char *data;
    size_t size;
};
/* Every view within its buffer, every accessor within its view, for the whole file. */
void check_accessors(const document &doc);
view open_view(document &doc, int index);
/* [count][width]: the first `width` components of each element, normalised integers as numbers. */
std::vector<double> read_numbers(document &doc, int accessor, size_t width);
/* Errors: HPR_ERR_FORMAT if an index is not below `vertex_count` or is the primitive restart value. */
std::vector<uint32_t> read_indices(document &doc, int accessor, size_t vertex_count,
                                   const std::string &where);

/* gltf_texture.cpp */
struct texture;
/* Textures of one document, decoded when first asked for. */
class texture_set
{
  public:
    explicit texture_set(document &doc);
    ~texture_set();
    texture &open(int index);
    /* Adds the texture to the scene, once; nothing if it is of one colour. */
    std::optional<uint32_t> hand_on(int index, hpr_scene *scene);

  private:
    document &doc;
    std::vector<std::unique_ptr<texture>> cache;
};
/* How a material samples a texture: uv' = offset + matrix * uv (KHR_texture_transform). */
struct texture_use {
    int index = -1, set = 0; /* set: TEXCOORD_<set> */
    double matrix[2][2] = {{1, 0}, {0, 1}};
    double offset[2] = {0, 0};
};
texture_use read_texture_use(const tinygltf::TextureInfo &info);
/* The colour of a texture that has only one, in linear light. */
std::optional<rgb> only_colour(texture &tex);
/*
 * Mean over a triangle of texture(uv) * colour, both interpolated from its corners:
 *   2 * integral over the reference triangle of T(u(xi, eta), v(xi, eta)) C(xi, eta)
 * The triangle is cut along the texel grid; on each piece the integrand is a cubic polynomial and is
 * integrated exactly. When it would fall into more than 65536 pieces, the first coarser level of a pyramid
 * of box means that does not takes the place of the picture: what is lost is at most the contrast within
 * one of its texels, along the triangle's edge only.
 */
rgb texture_triangle_mean(texture &tex, const double uv[3][2], const rgb colour[3]);

/* gltf_material.cpp */
struct material_use {
    std::optional<texture_use> base; /* base colour texture */
    rgb reflectance;                 /* factor, without texture and colour */
    std::optional<texture_use> glow; /* emissive texture, unless it is of one colour or nothing is emitted */
    rgb radiance;                    /* factor, W/m2/sr, with a texture of one colour */
};
/* Adds all materials in file order, so that indices agree. */
std::vector<material_use> add_materials(document &doc, texture_set &textures, const hpr_read_options &options,
                                        hpr_scene *scene);

/* gltf_node.cpp */
struct matrix {
    double m[3][4]; /* row-major: world = m * (x, y, z, 1) */
};
struct placed_node {
    uint32_t node;
    matrix world;
};
double determinant(const matrix &a);
/* Nodes of the chosen scene in the order of their indices. */
std::vector<placed_node> place_nodes(const document &doc, const hpr_read_options &options);

/* gltf_mesh.cpp */
void add_meshes(document &doc, texture_set &textures, const std::vector<material_use> &materials,
                const std::vector<placed_node> &nodes, hpr_scene *scene);
/* gltf_camera.cpp */
void add_cameras(const document &doc, const std::vector<placed_node> &nodes, hpr_scene *scene);

} // namespace gltf

#endif

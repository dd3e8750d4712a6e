/* What a file asks for and hprad leaves out: said once each. */
#include "io/gltf.hpp"

namespace gltf
{

namespace
{

bool is_handled(const std::string &extension)
{
    static const char *const handled[] = {"KHR_mesh_quantization", "KHR_materials_emissive_strength",
                                          "KHR_texture_transform", "KHR_materials_unlit"};
    for (const char *name : handled) {
        if (extension == name)
            return true;
    }
    return false;
}

void warn_count(const document &doc, const char *what, const char *unit, size_t count)
{
    if (count)
        hpr_warn(doc.context, "%s: %s (%s: %zu)", doc.path.c_str(), what, unit, count);
}

void warn_materials(const document &doc, const hpr_read_options &options)
{
    size_t alpha = 0, metallic = 0, rough = 0, normal = 0, occlusion = 0, unlit = 0;
    for (const tinygltf::Material &m : doc.model.materials) {
        alpha += m.alphaMode != "OPAQUE";
        metallic += m.pbrMetallicRoughness.metallicFactor > 0;
        rough += m.pbrMetallicRoughness.metallicRoughnessTexture.index >= 0;
        normal += m.normalTexture.index >= 0;
        occlusion += m.occlusionTexture.index >= 0;
        unlit += m.extensions.count("KHR_materials_unlit");
    }
    warn_count(doc, "alpha modes other than OPAQUE are ignored, alpha of textures included", "materials",
               alpha);
    warn_count(doc,
               options.metallic_black ? "the metallic part of reflectance is black"
                                      : "the metallic part of reflectance counts as diffuse",
               "materials", metallic);
    warn_count(doc, "metallic-roughness textures are ignored", "materials", rough);
    warn_count(doc, "normal maps are ignored", "materials", normal);
    warn_count(doc, "occlusion textures are ignored", "materials", occlusion);
    warn_count(doc, "KHR_materials_unlit is ignored: lit like all others", "materials", unlit);
}

void warn_meshes(const document &doc)
{
    size_t morphed = 0, skinned = 0;
    for (const tinygltf::Mesh &mesh : doc.model.meshes) {
        bool any = false;
        for (const tinygltf::Primitive &primitive : mesh.primitives)
            any = any || !primitive.targets.empty();
        morphed += any;
    }
    for (const tinygltf::Node &node : doc.model.nodes)
        skinned += node.skin >= 0;
    warn_count(doc, "morph targets are ignored: the base shape is read", "meshes", morphed);
    warn_count(doc, "skins are ignored: their meshes stand unposed", "nodes", skinned);
}

} // namespace

void warn_ignored(const document &doc, const hpr_read_options &options)
{
    const cJSON *root = doc.json.get(), *item;
    warn_materials(doc, options);
    warn_meshes(doc);
    int animations = cJSON_GetArraySize(cJSON_GetObjectItemCaseSensitive(root, "animations"));
    warn_count(doc, "animations are ignored: the scene stands still", "animations",
               static_cast<size_t>(animations));
    cJSON_ArrayForEach(item, cJSON_GetObjectItemCaseSensitive(root, "extensionsUsed"))
    {
        std::string name = one_line(cJSON_GetStringValue(item));
        if (!is_handled(name))
            hpr_warn(doc.context, "%s: extension %s is ignored", doc.path.c_str(), name.c_str());
    }
}

} // namespace gltf

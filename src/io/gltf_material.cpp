/* Materials: what a metallic-roughness material is to a diffuse solver. */
#include "io/gltf.hpp"

namespace gltf
{

namespace
{

double emissive_strength(const tinygltf::Material &material)
{
    auto found = material.extensions.find("KHR_materials_emissive_strength");
    if (found == material.extensions.end() || !found->second.Has("emissiveStrength"))
        return 1;
    return found->second.Get("emissiveStrength").GetNumberAsDouble();
}

/* emissiveFactor * emissiveStrength is radiance; an emissive texture counts by its mean over the picture. */
rgb emitted_radiance(document &doc, texture_set &textures, const tinygltf::Material &material,
                     size_t &textured_count)
{
    rgb out;
    double strength = emissive_strength(material);
    bool dark = true;
    for (size_t c = 0; c < 3; c++) {
        out[c] = material.emissiveFactor[c] * strength;
        dark = dark && out[c] == 0;
    }
    if (dark || material.emissiveTexture.index < 0)
        return out;
    textured_count++;
    rgb mean = texture_mean(textures.open(material.emissiveTexture.index));
    hpr_count(doc.context, HPR_COUNT_TEXTURES, 1);
    for (size_t c = 0; c < 3; c++)
        out[c] *= mean[c];
    if (hpr_cancelled(doc.context))
        fail(doc, HPR_ERR_INTERRUPTED, "interrupted");
    return out;
}

} // namespace

std::vector<material_use> add_materials(document &doc, texture_set &textures, const hpr_read_options &options,
                                        hpr_scene *scene)
{
    std::vector<material_use> uses;
    size_t textured_count = 0;
    for (const tinygltf::Material &material : doc.model.materials) {
        const tinygltf::PbrMetallicRoughness &pbr = material.pbrMetallicRoughness;
        double diffuse = options.metallic_black ? 1 - pbr.metallicFactor : 1;
        material_use use;
        rgb radiance = emitted_radiance(doc, textures, material, textured_count);
        /* The factor itself is what the message of a reflectance above 1 should show. */
        bool legal = true;
        for (size_t c = 0; c < 3; c++) {
            use.reflectance[c] = pbr.baseColorFactor[c];
            legal = legal && use.reflectance[c] <= 1;
        }
        for (size_t c = 0; legal && c < 3; c++)
            use.reflectance[c] *= diffuse;
        if (pbr.baseColorTexture.index >= 0)
            use.base = read_texture_use(pbr.baseColorTexture);
        check(hpr_scene_add_material(scene, one_line(material.name).c_str(), use.reflectance.data(),
                                     radiance.data(), material.doubleSided, nullptr));
        uses.push_back(use);
    }
    if (textured_count)
        hpr_warn(doc.context,
                 "%s: emissive textures count by the mean colour of their picture (materials: %zu)",
                 doc.path.c_str(), textured_count);
    return uses;
}

} // namespace gltf

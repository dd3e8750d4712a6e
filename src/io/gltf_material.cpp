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

/* emissiveFactor * emissiveStrength is radiance. */
void read_emission(document &doc, texture_set &textures, const tinygltf::Material &material,
                   material_use &use)
{
    double strength = emissive_strength(material);
    bool dark = true;
    for (size_t c = 0; c < 3; c++) {
        use.radiance[c] = material.emissiveFactor[c] * strength;
        dark = dark && use.radiance[c] == 0;
    }
    if (dark || material.emissiveTexture.index < 0)
        return;
    std::optional<rgb> colour = only_colour(textures.open(material.emissiveTexture.index));
    for (size_t c = 0; colour && c < 3; c++)
        use.radiance[c] *= (*colour)[c];
    if (colour)
        hpr_count(doc.context, HPR_COUNT_TEXTURES, 1);
    else
        use.glow = read_texture_use(material.emissiveTexture);
    if (hpr_cancelled(doc.context))
        fail(doc, HPR_ERR_INTERRUPTED, "interrupted");
}

} // namespace

std::vector<material_use> add_materials(document &doc, texture_set &textures, const hpr_read_options &options,
                                        hpr_scene *scene)
{
    std::vector<material_use> uses;
    for (const tinygltf::Material &material : doc.model.materials) {
        const tinygltf::PbrMetallicRoughness &pbr = material.pbrMetallicRoughness;
        double diffuse = options.metallic_black ? 1 - pbr.metallicFactor : 1;
        material_use use;
        read_emission(doc, textures, material, use);
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
                                     use.radiance.data(), material.doubleSided, nullptr));
        uses.push_back(use);
    }
    return uses;
}

} // namespace gltf

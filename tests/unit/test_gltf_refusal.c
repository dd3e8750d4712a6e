/* What the reader refuses: the status, the file's name, and what the message says of the fault. */
#include "gltf_file.h"

/* The body of a file whose buffer holds the 16 floats 0 .. 15 (64 bytes), and what must come of it. */
typedef struct refusal {
    const char *name, *body;
    hpr_status status;
    const char *message;
} refusal;

#define PRIMITIVE(text) "'meshes':[{'name':'Box','primitives':[{'attributes':{'POSITION':0}" text "}]}],"
#define MESH PRIMITIVE("")
#define POSITION "{'bufferView':0,'componentType':5126,'count':3,'type':'VEC3'}"
#define VIEWS "'bufferViews':[{'buffer':0,'byteLength':64}]"
#define ONE_VIEW(text) "'bufferViews':[{'buffer':0," text "}]"
#define TRIANGLE MESH "'accessors':[" POSITION "]," VIEWS
#define ACCESSOR(text) MESH "'accessors':[{" text "}]," VIEWS
#define SECOND(text) "'accessors':[" POSITION ",{" text "}]," VIEWS
#define SPARSE(text)                                                                                         \
    ACCESSOR("'componentType':5126,'count':3,'type':'VEC3','sparse':{" text ",'values':{'bufferView':0}}")
#define MATERIAL(text) TRIANGLE ",'materials':[{'name':'red'," text "}]"
#define TEXTURED(text)                                                                                       \
    PRIMITIVE(",'material':0")                                                                               \
    "'accessors':[" POSITION "]," VIEWS ",'materials':[{'pbrMetallicRoughness':"                             \
    "{'baseColorTexture':{'index':0}},'emissiveFactor':[1,1,1],'emissiveTexture':{'index':0}}]," text

static const refusal refusals[] = {
    {"accessor past its view", ACCESSOR("'bufferView':0,'componentType':5126,'count':6,'type':'VEC3'"),
     HPR_ERR_FORMAT,
     "accessor 0 (mesh 0 'Box', primitive 0) reads 8 bytes past its bufferView 0 of 64 bytes"},
    {"accessor offset past its view",
     ACCESSOR("'bufferView':0,'byteOffset':9007199254740992,'componentType':5126,'count':3,'type':'VEC3'"),
     HPR_ERR_FORMAT, "past its bufferView"},
    {"accessor of a huge count",
     ACCESSOR("'bufferView':0,'componentType':5126,'count':9007199254740992,'type':'VEC3'"), HPR_ERR_FORMAT,
     "past its bufferView"},
    {"count beyond 2^53", ACCESSOR("'bufferView':0,'componentType':5126,'count':1e300,'type':'VEC3'"),
     HPR_ERR_FORMAT, "accessor 0: count must be an integer"},
    {"count of zero", ACCESSOR("'bufferView':0,'componentType':5126,'count':0,'type':'VEC3'"), HPR_ERR_FORMAT,
     "accessor 0: count"},
    {"huge accessor without a view", ACCESSOR("'componentType':5126,'count':100000000,'type':'VEC3'"),
     HPR_ERR_UNSUPPORTED, "100000000 elements and no bufferView"},
    {"view past its buffer", MESH "'accessors':[" POSITION "]," ONE_VIEW("'byteOffset':1,'byteLength':64"),
     HPR_ERR_FORMAT, "bufferView 0 ends 1 bytes past its buffer 0 of 64 bytes"},
    {"stride below the element",
     MESH "'accessors':[" POSITION "]," ONE_VIEW("'byteLength':64,'byteStride':8"), HPR_ERR_FORMAT,
     "byteStride of 8"},
    {"stride of six", MESH "'accessors':[" POSITION "]," ONE_VIEW("'byteLength':64,'byteStride':14"),
     HPR_ERR_FORMAT, "byteStride"},
    {"unknown component type", ACCESSOR("'bufferView':0,'componentType':5124,'count':3,'type':'VEC3'"),
     HPR_ERR_FORMAT, "componentType 5124"},
    {"unknown type", ACCESSOR("'bufferView':0,'componentType':5126,'count':3,'type':'VEC5'"), HPR_ERR_FORMAT,
     "VEC5"},
    {"view that does not exist", ACCESSOR("'bufferView':1,'componentType':5126,'count':3,'type':'VEC3'"),
     HPR_ERR_FORMAT, "accessor 0: bufferView must be an index into bufferViews (there are 1), not 1"},
    {"negative accessor", "'meshes':[{'primitives':[{'attributes':{'POSITION':-1}}]}]", HPR_ERR_FORMAT,
     "mesh 0: primitives[0].attributes.POSITION"},
    {"integer positions without quantization",
     ACCESSOR("'bufferView':0,'componentType':5122,'count':3,'type':'VEC3'"), HPR_ERR_FORMAT,
     "KHR_mesh_quantization"},
    {"positions of two components", ACCESSOR("'bufferView':0,'componentType':5126,'count':3,'type':'VEC2'"),
     HPR_ERR_FORMAT, "POSITION has 2 components, not 3"},
    {"no positions", "'meshes':[{'primitives':[{'attributes':{}}]}]", HPR_ERR_FORMAT, "has no POSITION"},
    {"sparse index not rising", SPARSE("'count':2,'indices':{'bufferView':0,'componentType':5121}"),
     HPR_ERR_FORMAT, "sparse index 1 is 0"},
    {"sparse index out of range",
     SPARSE("'count':1,'indices':{'bufferView':0,'byteOffset':6,'componentType':5121}"), HPR_ERR_FORMAT,
     "sparse index 0 is 128"},
    {"more sparse values than elements", SPARSE("'count':4,'indices':{'bufferView':0,'componentType':5121}"),
     HPR_ERR_FORMAT, "replaces 4 of its 3 elements"},
    {"sparse indices past their view",
     SPARSE("'count':2,'indices':{'bufferView':0,'byteOffset':63,'componentType':5121}"), HPR_ERR_FORMAT,
     "reads 1 bytes past"},
    {"sparse indices of floats", SPARSE("'count':1,'indices':{'bufferView':0,'componentType':5126}"),
     HPR_ERR_FORMAT, "sparse indices of componentType 5126"},
    {"index out of range",
     PRIMITIVE(",'indices':1")
         SECOND("'bufferView':0,'byteOffset':6,'componentType':5121,'count':3,'type':'SCALAR'"),
     HPR_ERR_FORMAT, "mesh 0 'Box', primitive 0: index 0 (accessor 1) is 128, but there are 3 vertices"},
    {"indices of floats",
     PRIMITIVE(",'indices':1") SECOND("'bufferView':0,'componentType':5126,'count':3,'type':'SCALAR'"),
     HPR_ERR_FORMAT, "indices accessor 1 must be SCALAR"},
    {"colours of another count",
     "'meshes':[{'primitives':[{'attributes':{'POSITION':0,'COLOR_0':1}}]}]," SECOND(
         "'bufferView':0,'componentType':5126,'count':4,'type':'VEC3'"),
     HPR_ERR_FORMAT, "COLOR_0 has 4 elements, POSITION 3"},
    {"reflectance above one", MATERIAL("'pbrMetallicRoughness':{'baseColorFactor':[1.5,0,0,1]}"),
     HPR_ERR_FORMAT, "material 0 'red': reflectance 1.5"},
    {"negative emission", MATERIAL("'emissiveFactor':[0,-1,0]"), HPR_ERR_FORMAT, "emitted radiance -1"},
    {"colour factor of three numbers", MATERIAL("'pbrMetallicRoughness':{'baseColorFactor':[1,0,0]}"),
     HPR_ERR_FORMAT, "baseColorFactor must have 4 items, not 3"},
    {"infinite number", MATERIAL("'emissiveFactor':[0,1e999,0]"), HPR_ERR_FORMAT,
     "material 0 'red': emissiveFactor[1] must be a finite number"},
    {"text for a flag", MATERIAL("'doubleSided':'yes'"), HPR_ERR_FORMAT,
     "material 0 'red': doubleSided must be true or false, not \"yes\""},
    {"member twice", MATERIAL("'name':'blue'"), HPR_ERR_FORMAT, "name stands there twice"},
    {"texture without coordinates",
     PRIMITIVE(",'material':0") "'accessors':[" POSITION "]," VIEWS
                                ",'textures':[{'source':0}],'images':[{'uri':'x.png'}],'materials':"
                                "[{'pbrMetallicRoughness':{'baseColorTexture':{'index':0,'texCoord':1}}}]",
     HPR_ERR_FORMAT, "mesh 0 'Box', primitive 0 has no TEXCOORD_1"},
    {"picture of another kind", TEXTURED("'textures':[{'source':0}],'images':[{'bufferView':0}]"),
     HPR_ERR_FORMAT, "image 0 is neither a PNG nor a JPEG"},
    {"image that is not there",
     TEXTURED("'textures':[{'source':0}],'images':[{'name':'wood','uri':'wood%20floor.png'}]"), HPR_ERR_IO,
     "wood floor.png' cannot be read"},
    {"image without place", TEXTURED("'textures':[{'source':0}],'images':[{'name':'wood'}]"), HPR_ERR_FORMAT,
     "image 0 'wood' must have either a uri or a bufferView"},
    {"texture without picture", TEXTURED("'textures':[{'name':'t'}]"), HPR_ERR_UNSUPPORTED,
     "texture 0 't' has no PNG or JPEG source"},
    {"damaged image",
     TEXTURED("'textures':[{'source':0}],'images':[{'uri':'data:image/png;base64,"
              "iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAIAAACQd1PeAAAADElEQVR4nGP4//8='}]"),
     HPR_ERR_FORMAT, "image 0 cannot be decoded"},
    {"image of terapixels",
     TEXTURED("'textures':[{'source':0}],'images':[{'uri':'data:image/png;base64,"
              "iVBORw0KGgoAAAANSUhEUgAP//8AD///CAIAAACQd1PeAAAADElEQVR4nGP4//8='}]"),
     HPR_ERR_UNSUPPORTED, "1048575 x 1048575 pixels"},
    {"unknown wrap mode",
     TEXTURED("'textures':[{'source':0,'sampler':0}],'images':[{'bufferView':0}],'samplers':[{'wrapS':7}]"),
     HPR_ERR_FORMAT, "sampler 0 has the wrap mode 7"},
    {"cycle of nodes", "'nodes':[{'children':[1]},{'children':[2]},{'children':[1]}]", HPR_ERR_FORMAT,
     "node 1 is a child of node 0 and of node 2"},
    {"cycle without a root", "'nodes':[{'children':[1]},{'children':[0],'name':'loop'}]", HPR_ERR_FORMAT,
     "node 0 is among its own ancestors"},
    {"node with two parents", "'nodes':[{'children':[2]},{'children':[2]},{'name':'shared'}]", HPR_ERR_FORMAT,
     "node 2 'shared' is a child of node 0 and of node 1"},
    {"child that does not exist", "'nodes':[{'children':[9]}]", HPR_ERR_FORMAT,
     "node 0: children[0] must be an index into nodes (there are 1), not 9"},
    {"scene of a child", "'nodes':[{'children':[1]},{}],'scenes':[{'nodes':[1]}]", HPR_ERR_FORMAT,
     "scene 0: node 1 is not a root node"},
    {"default scene that does not exist", "'scene':1,'scenes':[{}]", HPR_ERR_FORMAT,
     "scene must be an index"},
    {"rotation of length two", "'nodes':[{'rotation':[0,0,0,2]}]", HPR_ERR_FORMAT,
     "node 0: the rotation's quaternion has length 2"},
    {"projective matrix", "'nodes':[{'matrix':[1,0,0,1,0,1,0,0,0,0,1,0,0,0,0,1]}]", HPR_ERR_FORMAT,
     "the last row of its matrix is 1 0 0 1"},
    {"matrix of fifteen", "'nodes':[{'matrix':[1,0,0,0,0,1,0,0,0,0,1,0,0,0,0]}]", HPR_ERR_FORMAT,
     "node 0: matrix must have 16 items, not 15"},
    {"camera without direction",
     "'nodes':[{'camera':0,'scale':[0,0,0]}],'cameras':[{'type':'perspective','perspective':"
     "{'yfov':1,'znear':1}}]",
     HPR_ERR_FORMAT, "camera 0: the matrix of its node 0 gives no view direction"},
    {"camera with far before near",
     "'nodes':[{'camera':0}],'cameras':[{'type':'perspective','perspective':"
     "{'yfov':1,'znear':1,'zfar':0.5}}]",
     HPR_ERR_FORMAT, "camera 0: zfar 0.5 is not beyond znear 1"},
    {"camera of unknown type", "'nodes':[{}],'cameras':[{'type':'fisheye'}]", HPR_ERR_FORMAT, "fisheye"},
    {"required extension", "'nodes':[{}],'extensionsRequired':['KHR_draco_mesh_compression','EXT_x']",
     HPR_ERR_UNSUPPORTED, "does not have: KHR_draco_mesh_compression, EXT_x"},
    {"missing member", "'nodes':[{}],'textures':[{}],'cameras':[{}]", HPR_ERR_FORMAT,
     "camera 0: type is missing"},
    {"list that is an object", "'nodes':{}", HPR_ERR_FORMAT, "nodes must be an array, not an object"},
};

static void refuses(void **state)
{
    const refusal *r = *state;
    void *made;
    assert_int_equal(fixture_setup(&made), 0);
    fixture *f = made;
    for (int i = 0; i < 16; i++)
        PUT(f, float, (float)i);
    /* Read as bytes: 0 0 0 0, 0 0 128 63, ... */
    hpr_status status = read_body(f, "%s", r->body);
    const char *message = hpr_context_error(f->ctx);
    bool good = status == r->status && strstr(message, "a.gltf: ") && strstr(message, r->message) &&
                !strchr(message, '\n') && !f->scene;
    if (!good)
        print_error("%s: status %d (expected %d), '%s' (expected '%s')\n", r->name, status, r->status,
                    message, r->message);
    fixture_teardown(&made);
    assert_true(good);
}

static void refuse_text(fixture *f, const char *text, hpr_status status, const char *message)
{
    assert_int_equal(read_text(f, text), status);
    assert_non_null(strstr(hpr_context_error(f->ctx), message));
    assert_non_null(strstr(hpr_context_error(f->ctx), "a.gltf"));
}

static void text_that_is_not_json(void **state)
{
    refuse_text(*state, "{'asset':{'version':'2.0'}", HPR_ERR_FORMAT, "not JSON");
}

static void json_that_nests_too_deep(void **state)
{
    char text[20000];
    memset(text, '[', sizeof text - 1);
    text[sizeof text - 1] = 0;
    refuse_text(*state, text, HPR_ERR_FORMAT, "not JSON");
}

static void json_without_asset(void **state)
{
    refuse_text(*state, "{'nodes':[]}", HPR_ERR_FORMAT, "asset.version is missing");
}

static void version_one(void **state)
{
    refuse_text(*state, "{'asset':{'version':'1.0'}}", HPR_ERR_UNSUPPORTED, "glTF version '1.0'");
}

static void text_that_is_not_utf8(void **state)
{
    refuse_text(*state, "{'asset':{'version':'2.0'},'nodes':[{'name':'\xff'}]}", HPR_ERR_FORMAT, "UTF-8");
}

static void missing_buffer(void **state)
{
    refuse_text(*state,
                "{'asset':{'version':'2.0'},'nodes':[{'mesh':0}],'buffers':[{'uri':'no.bin',"
                "'byteLength':64}]," TRIANGLE "}",
                HPR_ERR_IO, "no.bin' cannot be read: No such file");
}

static void short_buffer(void **state)
{
    refuse_text(*state,
                "{'asset':{'version':'2.0'},'nodes':[{'mesh':0}],'buffers':[{'uri':'data.bin',"
                "'byteLength':64}]," TRIANGLE "}",
                HPR_ERR_FORMAT, "buffer 0 should have 64 bytes, but data.bin has 0");
}

static void buffer_without_uri(void **state)
{
    refuse_text(*state,
                "{'asset':{'version':'2.0'},'nodes':[{'mesh':0}],'buffers':[{'byteLength':64}]," TRIANGLE "}",
                HPR_ERR_FORMAT, "buffer 0 has no uri");
}

static void non_finite_position(void **state)
{
    fixture *f = *state;
    PUT(f, float, 0, 0, 0, 1, NAN, 0, 0, 1, 0);
    assert_int_equal(
        read_body(f, "%s", MESH "'accessors':[" POSITION "],'bufferViews':[{'buffer':0,'byteLength':36}]"),
        HPR_ERR_FORMAT);
    assert_non_null(strstr(hpr_context_error(f->ctx), "vertex 1 has the coordinate nan"));
}

static void primitive_restart(void **state)
{
    fixture *f = *state;
    for (int i = 0; i < 300 * 3; i++)
        PUT(f, float, (float)(i % 7));
    size_t offset = PUT(f, unsigned char, 0, 1, 255);
    hpr_status status =
        read_body(f,
                  PRIMITIVE(",'indices':1") "'accessors':[{'bufferView':0,'componentType':5126,"
                                            "'count':300,'type':'VEC3'},{'bufferView':1,"
                                            "'componentType':5121,'count':3,'type':'SCALAR'}],"
                                            "'bufferViews':[{'buffer':0,'byteLength':3600},"
                                            "{'buffer':0,'byteOffset':%zu,'byteLength':3}]",
                  offset);
    assert_int_equal(status, HPR_ERR_FORMAT);
    assert_non_null(strstr(hpr_context_error(f->ctx), "primitive restart"));
}

static void scene_out_of_range(void **state)
{
    fixture *f = *state;
    f->options.scene_index = 2;
    refuse_text(f, "{'asset':{'version':'2.0'},'scenes':[{},{}]}", HPR_ERR_ARG,
                "scene 2 is asked for, but the file has 2");
}

static void largest_reflectance_above_one(void **state)
{
    fixture *f = *state;
    f->options.max_reflectance = 1.5;
    assert_int_equal(read_text(f, "{'asset':{'version':'2.0'}}"), HPR_ERR_ARG);
}

static void missing_file(void **state)
{
    fixture *f = *state;
    assert_int_equal(read_name(f, "none.gltf"), HPR_ERR_IO);
    assert_non_null(strstr(hpr_context_error(f->ctx), "none.gltf: cannot be read: No such file"));
}

static void directory_as_file(void **state)
{
    fixture *f = *state;
    assert_int_equal(read_name(f, "."), HPR_ERR_IO);
    assert_non_null(strstr(hpr_context_error(f->ctx), "directory"));
}

#define TEST(name) cmocka_unit_test_setup_teardown(name, fixture_setup, fixture_teardown)

int main(void)
{
    enum { TABLE = sizeof refusals / sizeof *refusals };
    struct CMUnitTest table[TABLE];
    for (size_t i = 0; i < TABLE; i++)
        table[i] =
            (struct CMUnitTest){refusals[i].name, refuses, NULL, NULL, (void *)(uintptr_t)&refusals[i]};
    const struct CMUnitTest tests[] = {
        TEST(text_that_is_not_json), TEST(json_that_nests_too_deep), TEST(json_without_asset),
        TEST(version_one),           TEST(text_that_is_not_utf8),    TEST(missing_buffer),
        TEST(short_buffer),          TEST(buffer_without_uri),       TEST(non_finite_position),
        TEST(primitive_restart),     TEST(scene_out_of_range),       TEST(largest_reflectance_above_one),
        TEST(missing_file),          TEST(directory_as_file),
    };
    int failed = cmocka_run_group_tests(table, NULL, NULL);
    return cmocka_run_group_tests(tests, NULL, NULL) + failed;
}

/* Geometry of glTF files: accessors, primitive modes, nodes, scenes, cameras, containers. */
#include "gltf_file.h"

#define TRIANGLE 0, 0, 0, 1, 0, 0, 0, 1, 0
#define MESH "'meshes':[{'primitives':[{'attributes':{'POSITION':0}}]}],"
#define FLOATS "'accessors':[{'bufferView':0,'componentType':5126,'count':3,'type':'VEC3'}],"
#define VIEW "'bufferViews':[{'buffer':0,'byteLength':36}]"

static void read_triangle(fixture *f, const char *more)
{
    PUT(f, float, TRIANGLE);
    char body[1024];
    snprintf(body, sizeof body, "%s%s", MESH FLOATS VIEW, more);
    assert_ok(f, read_body(f, body));
}

static void positions_without_indices(void **state)
{
    fixture *f = *state;
    read_triangle(f, "");
    assert_int_equal(f->scene->face_count, 1);
    assert_point(corner(f, 0, 2), 0, 1, 0, 0);
}

/* A quad's four vertices, the second triangle of its six indices is 0 2 3. */
static void read_indexed(fixture *f, int type, size_t offset)
{
    assert_ok(f, read_body(f,
                           "'meshes':[{'primitives':[{'attributes':{'POSITION':0},'indices':1}]}],"
                           "'accessors':[{'bufferView':0,'componentType':5126,'count':4,'type':'VEC3'},"
                           "{'bufferView':1,'componentType':%d,'count':6,'type':'SCALAR'}],"
                           "'bufferViews':[{'buffer':0,'byteLength':48},"
                           "{'buffer':0,'byteOffset':%zu,'byteLength':%zu}]",
                           type, offset, f->size - offset));
    assert_int_equal(f->scene->face_count, 2);
    assert_point(corner(f, 1, 2), 0, 1, 0, 0);
    assert_int_equal(f->scene->face_vertex[7], HPR_NONE);
}

#define QUAD 0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0

static void indices_of_one_byte(void **state)
{
    fixture *f = *state;
    PUT(f, float, QUAD);
    read_indexed(f, 5121, PUT(f, unsigned char, 0, 1, 2, 0, 2, 3));
}

static void indices_of_two_bytes(void **state)
{
    fixture *f = *state;
    PUT(f, float, QUAD);
    read_indexed(f, 5123, PUT(f, unsigned short, 0, 1, 2, 0, 2, 3));
}

static void indices_of_four_bytes(void **state)
{
    fixture *f = *state;
    PUT(f, float, QUAD);
    read_indexed(f, 5125, PUT(f, unsigned, 0, 1, 2, 0, 2, 3));
}

static void indices_without_view_are_zero(void **state)
{
    fixture *f = *state;
    PUT(f, float, TRIANGLE);
    assert_ok(f, read_body(f, "'meshes':[{'primitives':[{'attributes':{'POSITION':0},'indices':1}]}],"
                              "'accessors':[{'bufferView':0,'componentType':5126,'count':3,'type':'VEC3'},"
                              "{'componentType':5121,'count':3,'type':'SCALAR'}]," VIEW));
    assert_int_equal(f->scene->face_vertex[2], 0);
}

static void byte_stride(void **state)
{
    fixture *f = *state;
    PUT(f, float, 9, 0, 0, 0, 9, 1, 0, 0, 9, 0, 1, 0);
    assert_ok(f,
              read_body(f, MESH "'accessors':[{'bufferView':0,'byteOffset':4,'componentType':5126,'count':3,"
                                "'type':'VEC3'}],"
                                "'bufferViews':[{'buffer':0,'byteLength':48,'byteStride':16}]"));
    assert_point(corner(f, 0, 1), 1, 0, 0, 0);
}

static void sparse_over_a_view(void **state)
{
    fixture *f = *state;
    PUT(f, float, TRIANGLE);
    PUT(f, unsigned short, 1);
    PUT(f, float, 5, 6, 7);
    assert_ok(f,
              read_body(f, MESH "'accessors':[{'bufferView':0,'componentType':5126,'count':3,'type':'VEC3',"
                                "'sparse':{'count':1,'indices':{'bufferView':1,'componentType':5123},"
                                "'values':{'bufferView':1,'byteOffset':4}}}],"
                                "'bufferViews':[{'buffer':0,'byteLength':36},"
                                "{'buffer':0,'byteOffset':36,'byteLength':16}]"));
    assert_point(corner(f, 0, 1), 5, 6, 7, 0);
    assert_point(corner(f, 0, 2), 0, 1, 0, 0);
}

static void sparse_without_a_view(void **state)
{
    fixture *f = *state;
    PUT(f, unsigned char, 0, 2);
    PUT(f, float, 5, 6, 7, 1, 2, 3);
    assert_ok(f, read_body(f, MESH "'accessors':[{'componentType':5126,'count':3,'type':'VEC3',"
                                   "'sparse':{'count':2,'indices':{'bufferView':0,'componentType':5121},"
                                   "'values':{'bufferView':0,'byteOffset':4}}}],"
                                   "'bufferViews':[{'buffer':0,'byteLength':28}]"));
    assert_point(corner(f, 0, 0), 5, 6, 7, 0);
    assert_point(corner(f, 0, 1), 0, 0, 0, 0);
    assert_point(corner(f, 0, 2), 1, 2, 3, 0);
}

static void read_quantized(fixture *f, int type, const char *normalized, int stride)
{
    assert_ok(f, read_body(f,
                           "'extensionsUsed':['KHR_mesh_quantization']," MESH
                           "'accessors':[{'bufferView':0,'componentType':%d,'normalized':%s,'count':3,"
                           "'type':'VEC3'}],"
                           "'bufferViews':[{'buffer':0,'byteLength':%d,'byteStride':%d}]",
                           type, normalized, 3 * stride, stride));
}

static void quantized_bytes(void **state)
{
    fixture *f = *state;
    PUT(f, signed char, 0, 0, 0, 0, -128, 0, 127, 0, 0, 1, 0, 0);
    read_quantized(f, 5120, "false", 4);
    assert_point(corner(f, 0, 1), -128, 0, 127, 0);
}

static void normalized_bytes(void **state)
{
    fixture *f = *state;
    PUT(f, signed char, 0, 0, 0, 0, -128, 64, 127, 0, 0, 1, 0, 0);
    read_quantized(f, 5120, "true", 4);
    assert_point(corner(f, 0, 1), -1, 64.0 / 127, 1, 0);
}

static void quantized_unsigned_bytes(void **state)
{
    fixture *f = *state;
    PUT(f, unsigned char, 0, 0, 0, 0, 255, 1, 2, 0, 0, 1, 0, 0);
    read_quantized(f, 5121, "false", 4);
    assert_point(corner(f, 0, 1), 255, 1, 2, 0);
}

static void normalized_shorts(void **state)
{
    fixture *f = *state;
    PUT(f, short, 0, 0, 0, 0, -32768, 1, 32767, 0, 0, 1, 0, 0);
    read_quantized(f, 5122, "true", 8);
    assert_point(corner(f, 0, 1), -1, 1.0 / 32767, 1, 0);
}

static void quantized_unsigned_shorts(void **state)
{
    fixture *f = *state;
    PUT(f, unsigned short, 0, 0, 0, 0, 65535, 1, 2, 0, 0, 1, 0, 0);
    read_quantized(f, 5123, "false", 8);
    assert_point(corner(f, 0, 1), 65535, 1, 2, 0);
}

static void normalized_unsigned_shorts(void **state)
{
    fixture *f = *state;
    PUT(f, unsigned short, 0, 0, 0, 0, 65535, 1, 0, 0, 0, 1, 0, 0);
    read_quantized(f, 5123, "true", 8);
    assert_point(corner(f, 0, 1), 1, 1.0 / 65535, 0, 0);
}

/* Five vertices 0..4 at x = 0..4 in the given mode. */
static hpr_status read_mode(fixture *f, int mode)
{
    PUT(f, float, 0, 0, 0, 1, 1, 0, 2, 0, 0, 3, 1, 0, 4, 0, 0);
    return read_body(f,
                     "'meshes':[{'primitives':[{'attributes':{'POSITION':0},'mode':%d}]}],"
                     "'accessors':[{'bufferView':0,'componentType':5126,'count':5,'type':'VEC3'}],"
                     "'bufferViews':[{'buffer':0,'byteLength':60}]",
                     mode);
}

static void assert_face(fixture *f, size_t face, uint32_t a, uint32_t b, uint32_t c)
{
    const uint32_t *v = f->scene->face_vertex + 4 * face;
    assert_int_equal(v[0], a);
    assert_int_equal(v[1], b);
    assert_int_equal(v[2], c);
}

static void strip_turns_every_second_triangle(void **state)
{
    fixture *f = *state;
    assert_ok(f, read_mode(f, 5));
    assert_int_equal(f->scene->face_count, 3);
    assert_face(f, 0, 0, 1, 2);
    assert_face(f, 1, 1, 3, 2);
    assert_face(f, 2, 2, 3, 4);
}

static void fan_ends_at_its_first_vertex(void **state)
{
    fixture *f = *state;
    assert_ok(f, read_mode(f, 6));
    assert_int_equal(f->scene->face_count, 3);
    assert_face(f, 0, 1, 2, 0);
    assert_face(f, 2, 3, 4, 0);
}

static void incomplete_triangle_is_named_and_left_out(void **state)
{
    fixture *f = *state;
    assert_ok(f, read_mode(f, 4));
    assert_int_equal(f->scene->face_count, 1);
    assert_int_equal(count_warnings(f, "incomplete"), 1);
}

static void points_are_named_and_left_out(void **state)
{
    fixture *f = *state;
    assert_ok(f, read_mode(f, 0));
    assert_int_equal(f->scene->face_count, 0);
    assert_int_equal(count_warnings(f, "points and lines"), 1);
}

static void repeated_indices_join_strips(void **state)
{
    fixture *f = *state;
    PUT(f, float, QUAD);
    size_t offset = PUT(f, unsigned char, 0, 1, 2, 2, 3, 0);
    assert_ok(f, read_body(f,
                           "'meshes':[{'primitives':[{'attributes':{'POSITION':0},'indices':1,'mode':5}]}],"
                           "'accessors':[{'bufferView':0,'componentType':5126,'count':4,'type':'VEC3'},"
                           "{'bufferView':1,'componentType':5121,'count':6,'type':'SCALAR'}],"
                           "'bufferViews':[{'buffer':0,'byteLength':48},"
                           "{'buffer':0,'byteOffset':%zu,'byteLength':6}]",
                           offset));
    assert_int_equal(f->scene->face_count, 2);
    assert_face(f, 1, 2, 0, 3);
}

static void three_levels_of_nodes(void **state)
{
    fixture *f = *state;
    /* Vertex 1 is (1,0,0): scaled to (2,0,0), moved to (2,0.5,0), turned by 90 degrees about z to (-0.5,2,0),
     * moved by a matrix with translation (10, 0, 0.1) and x doubled: (9, 2, 0.1). */
    read_triangle(f, ",'scenes':[{'nodes':[2]}],'nodes':[{'mesh':0,'scale':[2,1,1],'translation':[0,0.5,0]},"
                     "{'children':[0],'rotation':[0,0,0.70710678118654757,0.70710678118654757]},"
                     "{'children':[1],'matrix':[2,0,0,0,0,1,0,0,0,0,1,0,10,0,0.1,1]}]");
    assert_point(corner(f, 0, 1), 9, 2, 0.1, 1e-15 * 9);
}

static void rotation_is_made_a_unit_quaternion(void **state)
{
    fixture *f = *state;
    read_triangle(f, ",'nodes':[{'mesh':0,'rotation':[0,0,0.7071068,0.7071068]}]");
    assert_point(corner(f, 0, 1), 0, 1, 0, 1e-15);
}

static void json_doubles_keep_every_bit(void **state)
{
    fixture *f = *state;
    read_triangle(f, ",'nodes':[{'mesh':0,'translation':[0.30000000000000004,1e-300,-123456789.12345679]}]");
    assert_point(corner(f, 0, 0), 0.30000000000000004, 1e-300, -123456789.12345679, 0);
}

static void mirroring_node_turns_the_winding(void **state)
{
    fixture *f = *state;
    read_triangle(f, ",'nodes':[{'mesh':0,'scale':[-1,1,1]}]");
    assert_face(f, 0, 0, 2, 1);
    assert_point(corner(f, 0, 2), -1, 0, 0, 0);
}

static void two_mirrors_keep_the_winding(void **state)
{
    fixture *f = *state;
    read_triangle(f, ",'nodes':[{'mesh':0,'scale':[-1,-1,1]}]");
    assert_face(f, 0, 0, 1, 2);
}

static void one_mesh_at_two_nodes(void **state)
{
    fixture *f = *state;
    read_triangle(f, ",'nodes':[{'mesh':0,'name':'left'},{'mesh':0,'name':'right','translation':[3,0,0]}]");
    assert_int_equal(f->scene->mesh_count, 2);
    assert_string_equal(f->scene->mesh_name[1], "right");
    assert_int_equal(f->scene->mesh_node[1], 1);
    assert_point(corner(f, 1, 0), 3, 0, 0, 0);
}

#define TWO_SCENES                                                                                           \
    ",'scenes':[{'nodes':[0]},{'nodes':[1]}],'nodes':[{'mesh':0},{'mesh':0,'translation':[3,0,0]}]"

static void default_scene(void **state)
{
    fixture *f = *state;
    read_triangle(f, ",'scene':1" TWO_SCENES);
    assert_int_equal(f->scene->mesh_count, 1);
    assert_int_equal(f->scene->mesh_node[0], 1);
}

static void first_scene_without_default(void **state)
{
    fixture *f = *state;
    read_triangle(f, TWO_SCENES);
    assert_int_equal(f->scene->mesh_node[0], 0);
}

static void scene_by_index(void **state)
{
    fixture *f = *state;
    f->options.scene_index = 1;
    read_triangle(f, TWO_SCENES);
    assert_int_equal(f->scene->mesh_node[0], 1);
}

static void no_scene_means_all_root_nodes(void **state)
{
    fixture *f = *state;
    read_triangle(f, ",'nodes':[{'mesh':0},{'children':[2]},{'mesh':0}]");
    assert_int_equal(f->scene->mesh_count, 2);
}

static const hpr_camera *read_camera(fixture *f, const char *node, const char *camera)
{
    char text[1024];
    snprintf(text, sizeof text, "{'asset':{'version':'2.0'},'nodes':[{'camera':0%s}],'cameras':[{%s}]}", node,
             camera);
    assert_ok(f, read_text(f, text));
    assert_int_equal(f->scene->camera_count, 1);
    return f->scene->camera;
}

#define PERSPECTIVE "'type':'perspective','perspective':{'yfov':0.8,'aspectRatio':1.5,'znear':0.1,'zfar':9}"

static void perspective_camera(void **state)
{
    const hpr_camera *c = read_camera(*state, "", PERSPECTIVE);
    assert_int_equal(c->kind, HPR_CAMERA_PERSPECTIVE);
    assert_point((double[]){c->yfov_rad, c->aspect, c->znear}, 0.8, 1.5, 0.1, 0);
    assert_near(c->zfar, 9, 0);
}

static void open_perspective_camera(void **state)
{
    const hpr_camera *c = read_camera(*state, "", "'type':'perspective','perspective':{'yfov':1,'znear':1}");
    assert_true(isinf(c->zfar));
    assert_near(c->aspect, 0, 0);
}

static void orthographic_camera(void **state)
{
    const hpr_camera *c = read_camera(
        *state, "", "'type':'orthographic','orthographic':{'xmag':2,'ymag':3,'znear':0,'zfar':9}");
    assert_int_equal(c->kind, HPR_CAMERA_ORTHOGRAPHIC);
    assert_point((double[]){c->xmag, c->ymag, c->zfar}, 2, 3, 9, 0);
}

static void camera_pose_ignores_scale_and_mirror(void **state)
{
    const hpr_camera *c =
        read_camera(*state, ",'translation':[1,2,3],'scale':[-5,2,3],'rotation':[0,0.6,0,0.8]", PERSPECTIVE);
    assert_point(c->origin, 1, 2, 3, 0);
    assert_point(c->backward, 0.96, 0, 0.28, 2e-16);
    assert_point(c->up, 0, 1, 0, 2e-16);
    assert_point(c->right, 0.28, 0, -0.96, 2e-16);
}

static void camera_takes_its_nodes_name(void **state)
{
    assert_string_equal(read_camera(*state, ",'name':'node'", "'name':'lens'," PERSPECTIVE)->name, "node");
}

static void camera_of_a_nameless_node_keeps_its_name(void **state)
{
    assert_string_equal(read_camera(*state, "", "'name':'lens'," PERSPECTIVE)->name, "lens");
}

static void camera_without_any_name(void **state)
{
    assert_string_equal(read_camera(*state, "", PERSPECTIVE)->name, "");
}

/* A .glb of the JSON and the fixture's data; returns its size. */
static size_t make_glb(fixture *f, const char *text, unsigned char *out)
{
    uint32_t json = (uint32_t)((strlen(text) + 3) / 4 * 4), data = (uint32_t)((f->size + 3) / 4 * 4);
    uint32_t header[] = {0x46546c67, 2, 28 + json + data, json, 0x4e4f534a}, chunk[] = {data, 0x004e4942};
    memset(out, ' ', 20 + json);
    memcpy(out, header, sizeof header);
    for (size_t i = 0; text[i]; i++)
        out[20 + i] = text[i] == '\'' ? '"' : (unsigned char)text[i];
    memcpy(out + 20 + json, chunk, sizeof chunk);
    memcpy(out + 28 + json, f->data, data);
    return header[2];
}

#define GLB_TEXT                                                                                             \
    "{'asset':{'version':'2.0'},'nodes':[{'mesh':0}],'buffers':[{'byteLength':36}]," MESH FLOATS VIEW "}"

static void glb_is_known_by_its_magic(void **state)
{
    fixture *f = *state;
    unsigned char glb[2048];
    PUT(f, float, TRIANGLE);
    write_file(f, "b.gltf", glb, make_glb(f, GLB_TEXT, glb));
    assert_ok(f, read_name(f, "b.gltf"));
    assert_point(corner(f, 0, 2), 0, 1, 0, 0);
}

static void glb_cut_short_is_refused(void **state)
{
    fixture *f = *state;
    unsigned char glb[2048];
    PUT(f, float, TRIANGLE);
    size_t size = make_glb(f, GLB_TEXT, glb);
    for (size_t cut = 0; cut < size; cut++) {
        write_file(f, "b.glb", glb, cut);
        assert_int_equal(read_name(f, "b.glb"), HPR_ERR_FORMAT);
        assert_non_null(strstr(hpr_context_error(f->ctx), "b.glb"));
    }
}

static void read_uri(fixture *f, const char *name, const char *uri)
{
    char text[1024];
    PUT(f, float, TRIANGLE, 99);
    if (name)
        write_file(f, name, f->data, f->size);
    snprintf(text, sizeof text,
             "{'asset':{'version':'2.0'},'nodes':[{'mesh':0}],'buffers':[{'uri':'%s','byteLength':36}],%s}",
             uri, MESH FLOATS VIEW);
    assert_ok(f, read_text(f, text));
    assert_point(corner(f, 0, 2), 0, 1, 0, 0);
}

static void uri_is_percent_decoded(void **state)
{
    read_uri(*state, "my data+1.bin", "my%20data+1.bin");
}

static void data_uri(void **state)
{
    read_uri(*state, NULL,
             "data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA");
}

static void every_failing_allocation_is_reported(void **state)
{
    fixture *f = *state;
    read_triangle(f, ",'cameras':[{" PERSPECTIVE "}],'materials':[{'name':'m'}],"
                     "'nodes':[{'mesh':0,'camera':0,'name':'n'}]");
    for (long k = 0;; k++) {
        f->allocations_left = k;
        hpr_status status = read_name(f, "a.gltf");
        f->allocations_left = -1;
        if (status == HPR_OK)
            break;
        assert_int_equal(status, HPR_ERR_MEMORY);
        assert_null(f->scene);
    }
}

#define TEST(name) cmocka_unit_test_setup_teardown(name, fixture_setup, fixture_teardown)

int main(void)
{
    const struct CMUnitTest tests[] = {
        TEST(positions_without_indices),
        TEST(indices_of_one_byte),
        TEST(indices_of_two_bytes),
        TEST(indices_of_four_bytes),
        TEST(indices_without_view_are_zero),
        TEST(byte_stride),
        TEST(sparse_over_a_view),
        TEST(sparse_without_a_view),
        TEST(quantized_bytes),
        TEST(normalized_bytes),
        TEST(quantized_unsigned_bytes),
        TEST(normalized_shorts),
        TEST(quantized_unsigned_shorts),
        TEST(normalized_unsigned_shorts),
        TEST(strip_turns_every_second_triangle),
        TEST(fan_ends_at_its_first_vertex),
        TEST(incomplete_triangle_is_named_and_left_out),
        TEST(points_are_named_and_left_out),
        TEST(repeated_indices_join_strips),
        TEST(three_levels_of_nodes),
        TEST(rotation_is_made_a_unit_quaternion),
        TEST(json_doubles_keep_every_bit),
        TEST(mirroring_node_turns_the_winding),
        TEST(two_mirrors_keep_the_winding),
        TEST(one_mesh_at_two_nodes),
        TEST(default_scene),
        TEST(first_scene_without_default),
        TEST(scene_by_index),
        TEST(no_scene_means_all_root_nodes),
        TEST(perspective_camera),
        TEST(open_perspective_camera),
        TEST(orthographic_camera),
        TEST(camera_pose_ignores_scale_and_mirror),
        TEST(camera_takes_its_nodes_name),
        TEST(camera_of_a_nameless_node_keeps_its_name),
        TEST(camera_without_any_name),
        TEST(glb_is_known_by_its_magic),
        TEST(glb_cut_short_is_refused),
        TEST(uri_is_percent_decoded),
        TEST(data_uri),
        TEST(every_failing_allocation_is_reported),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

/* Relievo: exploration of shaders by feature vectors, for hosts that run their shaders themselves.
 *
 * An author marks expressions of a shader in comments ("//. vector density; gradient; alpha"); docs/shaders.md has the
 * language. The library turns the marks into code that takes the vectors, logs those of one pixel and computes the degree to
 * which a pixel resembles positive examples (Mindek et al. 2013, Sections 4 and 5). It needs no context and no graphics
 * device: a text goes in; a text and the layout of two storage buffers come out. The host
 *
 *   1. makes the buffers and binds them where rlv_shader_layout says: one of examples, which the shader reads, and a log,
 *      which it writes;
 *   2. clears the log, writes the words of rlv_shader_pack_examples with RLV_SHADER_CLASSIFY and the column and row of a
 *      pixel, draws that pixel, and gives the log to rlv_shader_unpack_log, which returns the vector of the pixel;
 *   3. adds the vector to its examples, writes their words with RLV_SHADER_RENDER, and draws: where the shader uses
 *      `confidence`, the picture shows what resembles the examples. No shader is compiled anew.
 *
 * Words have 32 bits:
 *
 *   examples  0 mode; 1 and 2 column and row of the pixel, or columns and rows of the mask; 3 number of examples; 4 exponent;
 *             then a factor for each of the n features; then for each example 1 or 0 for its class, and n features
 *   log       0 vectors of a weight other than 0; 1 all vectors; 2 sum of weights; then n accumulated features; then for
 *             each vector its weight and n features, as many as the buffer has room for; for RLV_SHADER_MASK in place of
 *             the features the membership of each pixel, row after row; for RLV_SHADER_VERTICES in their place 6 + n numbers
 *             of each vertex, instance after instance: its position in clip space, how many vectors of a weight other than 0
 *             it took, the sum of their weights, and its accumulated features
 *
 * A fragment or compute shader acts on RLV_SHADER_CLASSIFY and RLV_SHADER_MASK, a vertex shader on the two other modes. Run a
 * vertex shader once for each vertex that is asked for, for instance as a point; the vector of a pixel is the mean of those of
 * the triangle that is seen there, weighted as its outputs are interpolated.
 *
 * A shader is never changed: its calls may run at the same time. Reading one takes milliseconds, on a thread of its own. */
#ifndef RELIEVO_SHADER_H
#define RELIEVO_SHADER_H

#include "relievo/context.h"

typedef struct RlvShader {
    uint64_t id;
} RlvShader;

typedef enum RlvShaderLanguage {
    RLV_SHADER_GLSL = 0, /* any version; those before 4.40, WebGL and Shadertoy are rewritten to 4.50 */
    RLV_SHADER_WGSL = 1
} RlvShaderLanguage;

typedef enum RlvShaderStage {
    RLV_SHADER_VERTEX = 0,
    RLV_SHADER_FRAGMENT = 1,
    RLV_SHADER_COMPUTE = 2
} RlvShaderStage;

typedef enum RlvShaderText {
    RLV_SHADER_MARKED = 0,        /* as the author wrote it, with its marks */
    RLV_SHADER_AUGMENTED = 1,     /* with the marks as code, in the language of the author */
    RLV_SHADER_AUGMENTED_WGSL = 2 /* the same in WGSL */
} RlvShaderText;

typedef enum RlvShaderDeclared {
    RLV_SHADER_GLOBAL = 0,    /* outside of functions */
    RLV_SHADER_PARAMETER = 1, /* as a parameter of a function */
    RLV_SHADER_LOCAL = 2      /* in a function */
} RlvShaderDeclared;

/* How the vectors of a pixel become its vector. Those of weight 0 do not count. */
typedef enum RlvShaderAccumulation {
    RLV_SHADER_AVERAGE = 0, /* weighted */
    RLV_SHADER_SUM = 1,     /* of each feature times its weight */
    RLV_SHADER_MIN = 2,
    RLV_SHADER_MAX = 3,
    RLV_SHADER_FIRST = 4,
    RLV_SHADER_LAST = 5
} RlvShaderAccumulation;

typedef enum RlvShaderClass {
    RLV_SHADER_NEGATIVE = 0,
    RLV_SHADER_POSITIVE = 1
} RlvShaderClass;

/* What an augmented shader does beside its picture. */
typedef enum RlvShaderMode {
    RLV_SHADER_RENDER = 0,   /* nothing */
    RLV_SHADER_CLASSIFY = 1, /* logs the vectors of the pixel at a column and row */
    RLV_SHADER_MASK = 2,     /* logs the membership of each pixel of so many columns and rows */
    RLV_SHADER_CLASSIFY_VERTEX = 3, /* a vertex shader logs the vectors of a vertex of an instance */
    RLV_SHADER_VERTICES = 4         /* a vertex shader lists so many vertices of so many instances */
} RlvShaderMode;

typedef struct RlvShaderOptions {
    uint32_t struct_size;
    uint32_t language; /* RlvShaderLanguage */
    uint32_t stage;    /* RlvShaderStage; WGSL names the stages of its entry points itself */
    uint32_t reserved; /* 0 */
    const char *name;  /* what errors call the shader, usually the path of its file; NULL for "shader" */
} RlvShaderOptions;

#define RLV_SHADER_OPTIONS_INIT {sizeof(RlvShaderOptions), RLV_SHADER_GLSL, RLV_SHADER_FRAGMENT, 0, NULL}

/* A float or a vector of floats that a shader declares. Longer texts are cut. */
typedef struct RlvShaderVariable {
    uint32_t struct_size;
    uint32_t components;     /* 1 to 4 */
    uint32_t declared;       /* RlvShaderDeclared */
    uint32_t is_initialized; /* 0 or 1: whether its declaration gives it a value */
    uint32_t line, column;   /* of its name, counted from 1, columns in characters */
    uint64_t scope_start;    /* the bytes of the text in which its name means this variable */
    uint64_t scope_end;
    char name[RLV_NAME_SIZE];
    char label[RLV_NAME_SIZE];       /* the name that a mark gives it; "" for none */
    char function[RLV_NAME_SIZE];    /* the function that declares it; "" for none */
    char description[RLV_TEXT_SIZE]; /* of a mark; "" for none */
} RlvShaderVariable;

#define RLV_SHADER_VARIABLE_INIT {sizeof(RlvShaderVariable), 0, 0, 0, 0, 0, 0, 0, {0}, {0}, {0}, {0}}

/* Where an augmented shader finds its buffers, and what its vectors are. */
typedef struct RlvShaderLayout {
    uint32_t struct_size;
    uint32_t group;            /* bind group or descriptor set of both buffers */
    uint32_t examples_binding; /* the binding of the examples, a storage buffer that is read */
    uint32_t log_binding;      /* the binding of the log, a storage buffer that is read and written */
    uint32_t feature_count;    /* numbers of a vector, 1 to 64 */
    uint32_t accumulation;     /* RlvShaderAccumulation */
    uint32_t site_count;       /* places of the text at which vectors are taken */
    uint32_t uses_confidence;  /* 0 or 1: whether examples change the picture */
    uint32_t examples_head;    /* words of the examples before the factors */
    uint32_t log_head;         /* words of the log before the accumulated features */
} RlvShaderLayout;

#define RLV_SHADER_LAYOUT_INIT {sizeof(RlvShaderLayout), 0, 0, 0, 0, 0, 0, 0, 0, 0}

/* A feature of the vectors of a shader. Longer texts are cut. */
typedef struct RlvShaderFeature {
    uint32_t struct_size;
    uint32_t reserved;               /* 0 */
    char name[RLV_TEXT_SIZE];        /* the name that a mark gives the variable, or the expression */
    char expression[RLV_TEXT_SIZE];  /* in the language of the shader */
    char description[RLV_TEXT_SIZE]; /* of a mark; "" for none */
} RlvShaderFeature;

#define RLV_SHADER_FEATURE_INIT {sizeof(RlvShaderFeature), 0, {0}, {0}, {0}}

/* Classified pixels. The membership of a vector is the mean of the classes, weighted by the inverse distances of the examples
 * to the power of the exponent (Equation 2). */
typedef struct RlvShaderExamples {
    uint32_t struct_size;
    uint32_t feature_count; /* numbers of a vector, 1 to 64 */
    size_t count;           /* examples, at most 4096; without any, every membership is 0.5 */
    const uint32_t *classes; /* RlvShaderClass of each */
    size_t class_stride;     /* bytes from one to the next, 0 for packed */
    const float *vectors;    /* feature_count finite numbers of each */
    size_t vector_stride;    /* bytes from one vector to the next, 0 for packed */
    float exponent;          /* 0.01 to 64: the larger, the harder the border between the classes */
    uint32_t is_scaled;      /* whether features are divided by the range that they have over the examples */
} RlvShaderExamples;

#define RLV_SHADER_EXAMPLES_INIT {sizeof(RlvShaderExamples), 0, 0, NULL, 0, NULL, 0, 2.0f, 0}

/* Reads a shader, UTF-8 of at most 1 MiB, and augments it if it has a mark `vector`; options may be NULL for the defaults. Fails
 * with RLV_ERROR_INVALID and the line and column of the first fault if the shader or a mark cannot be read. */
RLV_API RlvResult rlv_shader_create(const char *source, const RlvShaderOptions *options, RlvShader *out);

RLV_API RlvResult rlv_shader_retain(RlvShader shader);
RLV_API RlvResult rlv_shader_release(RlvShader shader);

/* Counts the float variables. No failure of its own. */
RLV_API RlvResult rlv_shader_variable_count(RlvShader shader, size_t *out);

/* Describes a float variable; they are in the order of the text. Fails with RLV_ERROR_NOT_FOUND beyond the count. */
RLV_API RlvResult rlv_shader_variable(RlvShader shader, size_t index, RlvShaderVariable *out);

/* Makes a shader with another mark, which takes a vector of count variables, by their indices, behind the last of them.
 * weight is an expression of the shading language; NULL means 1.0. Fails if no variable is chosen, if one cannot be seen
 * from where the last is declared, or if no statement can stand there. */
RLV_API RlvResult rlv_shader_mark(RlvShader shader, const uint32_t *variables, size_t count, const char *weight,
                                  RlvShader *out);

/* Writes a text of the shader, of the kind RlvShaderText, with its final zero, and its length without it. text may be NULL
 * to ask for the length. Fails if size is too small, if the shader takes no vector and the augmented text is wanted, or if it
 * uses what WGSL lacks. */
RLV_API RlvResult rlv_shader_text(RlvShader shader, uint32_t kind, char *text, size_t size, size_t *length);

/* Describes the buffers of the augmented shader. Fails if the shader takes no vector. */
RLV_API RlvResult rlv_shader_layout(RlvShader shader, RlvShaderLayout *out);

/* Describes a feature of the vectors. Fails if the shader takes no vector, and with RLV_ERROR_NOT_FOUND beyond the count. */
RLV_API RlvResult rlv_shader_feature(RlvShader shader, size_t index, RlvShaderFeature *out);

/* Writes the words of the buffer of examples for a mode of RlvShaderMode, and their number to count. x and y are column and
 * row from the upper left corner to classify a pixel, columns and rows for a mask, the indices of vertex and instance to
 * classify a vertex, numbers of vertices and of instances to list them, and without meaning to render. words may be NULL to
 * ask for the number. Fails if there are more than capacity, or if an example is not finite or of no class. */
RLV_API RlvResult rlv_shader_pack_examples(const RlvShaderExamples *examples, uint32_t mode, uint32_t x, uint32_t y,
                                           uint32_t *words, size_t capacity, size_t *count);

/* Writes the vector of a classified pixel, of feature_count numbers, and how many vectors the pixel took; taken may be NULL. count
 * is at least log_head + feature_count words. Fails if the pixel took no vector of a weight other than 0, if the weights of an
 * average sum to 0, or if the vector is not finite. */
RLV_API RlvResult rlv_shader_unpack_log(RlvShader shader, const uint32_t *words, size_t count, float *vector, size_t capacity,
                                        uint32_t *taken);

/* Writes the membership, 0 to 1, of each of count vectors, stride bytes from one another, 0 for packed; 0.5 for one that is not
 * finite. They equal the shader's `confidence`. Fails as rlv_shader_pack_examples does. */
RLV_API RlvResult rlv_shader_membership(const RlvShaderExamples *examples, const float *vectors, size_t count, size_t stride,
                                        float *out);

#endif

/* weft adapts tetrahedral meshes to anisotropic metric fields: the interface for C, and for all languages
   that call C. It says in C what <weft/weft.h> says in C++, where everything is described in full.

     weft_mesh* mesh = NULL;
     weft_metric* metric = NULL;
     weft_options* options = NULL;
     weft_result* result = NULL;
     weft_status status = weft_mesh_read("wing.meshb", &mesh);
     if (!status) status = weft_metric_read("wing.solb", mesh, &metric);
     if (!status) status = weft_options_create(NULL, &options);
     if (!status) status = weft_options_set(options, "complexity", "500000");
     if (!status) status = weft_adapt(mesh, metric, options, NULL, &result);
     if (!status) status = weft_result_write(result, "fine.meshb");
     if (status) fprintf(stderr, "%s\n", weft_last_error());
     weft_free(mesh); weft_free(metric); weft_free(options); weft_free(result);

   - Functions return WEFT_OK (0) or what went wrong; weft_last_error() then says it in words. Nothing is
     printed, no signal handled, the process never ended.
   - Objects are opaque handles, which weft_free() frees. A handle that has been freed, or is of another kind,
     is refused with WEFT_MISUSE. A function that fails leaves its outputs as they are.
   - Arrays of the caller are read during the call and never kept. Pointers that functions give out belong to
     the object and are valid until it is freed (until it is changed or freed, for a mesh and for fields).
   - Indices and counts are 64-bit, indices count from 0. Errors name arrays by argument and index; what they
     call a vertex, tet or triangle with a number counts from 1, as in files.
   - Tensors have six numbers in a row; which comes where has to be said (weft_tensor_order).
   - Functions may be called from several threads at the same time, as long as none changes an object that
     another uses. */
#ifndef WEFT_WEFT_C_H
#define WEFT_WEFT_C_H

#include <mpi.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#if defined(__GNUC__)
#define WEFT_C_API __attribute__((visibility("default")))
#else
#define WEFT_C_API
#endif

/* Any number may come from C: with its type said a C++ compiler allows it too. */
#ifdef __cplusplus
#define WEFT_C_ENUM(name) enum name : unsigned int
#else
#define WEFT_C_ENUM(name) enum name
#endif

typedef struct weft_mesh weft_mesh;
typedef struct weft_metric weft_metric;
typedef struct weft_fields weft_fields;
typedef struct weft_options weft_options;
typedef struct weft_part weft_part;
typedef struct weft_result weft_result;
typedef struct weft_text weft_text;

typedef WEFT_C_ENUM(weft_status){
    WEFT_OK = 0,
    WEFT_MISUSE = 1,       /* a NULL or freed handle, one of another kind, wrong sizes */
    WEFT_INPUT_ERROR = 2,  /* data that cannot be used; the text names file, entity and reason */
    WEFT_OPTION_ERROR = 3, /* an option that is unknown, makes no sense or contradicts another */
    WEFT_RUN_ERROR = 4,    /* a run on several ranks came to no end */
    WEFT_OUT_OF_MEMORY = 5,
    WEFT_INTERNAL_ERROR = 6 /* a fault of weft */
} weft_status;

/* "0.1.0" */
WEFT_C_API const char* weft_version(void);
/* What the last call of this thread that failed had to say; "" before the first. Valid until the next fails.
 */
WEFT_C_API const char* weft_last_error(void);
/* For interfaces of other languages, which refuse arguments of their own: WEFT_MISUSE, and `why` is the last
   error. */
WEFT_C_API weft_status weft_refuse(const char* why);
/* "input error", ... */
WEFT_C_API const char* weft_status_name(weft_status status);
/* Frees any handle. NULL is allowed. */
WEFT_C_API weft_status weft_free(void* handle);
/* The letters of a text, valid until it is freed. */
WEFT_C_API weft_status weft_text_get(const weft_text* text, const char** letters);
/* How many handles there are: those that a program has forgotten to free, at its end. */
WEFT_C_API int64_t weft_handles(void);

/* ------------------------------------------------------------------------------------------------ Meshes */

/* The arrays of a mesh beside points and tets, by the numbers of a row. */
typedef WEFT_C_ENUM(weft_array){
    WEFT_TETS = 0,               /* 4: indices of points */
    WEFT_TET_REFS = 1,           /* 1 */
    WEFT_TRIANGLES = 2,          /* 3: indices of points */
    WEFT_TRIANGLE_REFS = 3,      /* 1 */
    WEFT_EDGES = 4,              /* 2: indices of points */
    WEFT_EDGE_REFS = 5,          /* 1 */
    WEFT_POINT_REFS = 6,         /* 1 */
    WEFT_CORNERS = 7,            /* 1: index of a point */
    WEFT_REQUIRED_POINTS = 8,    /* 1: index of a point */
    WEFT_RIDGES = 9,             /* 1: index of an edge */
    WEFT_REQUIRED_EDGES = 10,    /* 1: index of an edge */
    WEFT_REQUIRED_TRIANGLES = 11 /* 1: index of a triangle */
} weft_array;

/* Of points x y z, x y z, ... and tets of four indices each. Both counts may be 0. */
WEFT_C_API weft_status weft_mesh_create(int64_t num_points, const double* points, int64_t num_tets,
                                        const int64_t* tets, weft_mesh** mesh);
/* The same with 32-bit indices. */
WEFT_C_API weft_status weft_mesh_create32(int64_t num_points, const double* points, int64_t num_tets,
                                          const int32_t* tets, weft_mesh** mesh);
/* Replaces an array by `count` rows. */
WEFT_C_API weft_status weft_mesh_set(weft_mesh* mesh, weft_array which, int64_t count, const int64_t* values);
WEFT_C_API weft_status weft_mesh_num_points(const weft_mesh* mesh, int64_t* count);
/* The rows of an array. */
WEFT_C_API weft_status weft_mesh_count(const weft_mesh* mesh, weft_array which, int64_t* count);
/* Copies an array to where `capacity` numbers have room. */
WEFT_C_API weft_status weft_mesh_get(const weft_mesh* mesh, weft_array which, int64_t capacity,
                                     int64_t* values);
/* Weft's own arrays, not copied: three doubles a point; four indices a tet. */
WEFT_C_API weft_status weft_mesh_points(const weft_mesh* mesh, const double** points);
WEFT_C_API weft_status weft_mesh_tets(const weft_mesh* mesh, const uint32_t** tets);
/* Files of any format that the command knows. */
WEFT_C_API weft_status weft_mesh_read(const char* path, weft_mesh** mesh);
WEFT_C_API weft_status weft_mesh_write(const weft_mesh* mesh, const char* path);
/* The full check with exact arithmetic. `num_problems` is 0 for a mesh that conforms; else weft_last_error()
   names some, though the status is WEFT_OK. `volume` may be NULL. */
WEFT_C_API weft_status weft_mesh_verify(const weft_mesh* mesh, int64_t* num_problems, double* volume);
/* The same against another mesh of the same domain: in how much volumes and areas by reference differ by more
   than 1e-9, and where the bodies touch themselves. 0: they agree; else weft_last_error() says how they do.
 */
WEFT_C_API weft_status weft_mesh_compare(const weft_mesh* mesh, const weft_mesh* other,
                                         int64_t* num_differences);
/* Mends what can be mended of a mesh that weft_adapt() would refuse; `fields` (NULL: none) at its vertices
   follow. `mends`, which may be NULL: what was done, a line each, to be freed. What cannot be mended is
   refused, and nothing changes. */
WEFT_C_API weft_status weft_mesh_repair(weft_mesh* mesh, weft_fields* fields, weft_text** mends);
/* The same for triangles that are to bound a volume, before weft_fill(). */
WEFT_C_API weft_status weft_surface_repair(weft_mesh* surface, weft_text** mends);
/* The same for a metric in fields (tensors or sizes) at the vertices of `mesh`. */
WEFT_C_API weft_status weft_fields_repair_metric(weft_fields* fields, const weft_mesh* mesh,
                                                 weft_text** mends);
/* The unit cube of cells, 6 tets each. */
WEFT_C_API weft_status weft_mesh_box(int64_t nx, int64_t ny, int64_t nz, weft_mesh** mesh);
/* The same between two corners x y z. */
WEFT_C_API weft_status weft_mesh_box_between(const int64_t cells[3], const double min[3], const double max[3],
                                             weft_mesh** mesh);

/* How files are written where their format leaves a choice; others take no notice. */
typedef struct weft_write_settings {
  size_t size;          /* sizeof(weft_write_settings) */
  const char* encoding; /* "binary"; "ascii", of .msh, .stl, .ply and .vtu; "big-endian", of .ply */
  int32_t msh_version;  /* 4: MSH 4.1; 2: MSH 2.2 */
  int32_t compress;     /* 1: the arrays of a .vtu or .pvtu are compressed */
  int32_t pieces;       /* of a .pvtu */
} weft_write_settings;
WEFT_C_API weft_status weft_write_settings_default(weft_write_settings* settings);
/* From file to file, with fields and names of references, as `weft convert` does. `solution`, a file of
   fields at the vertices, and `settings` may be NULL. `dropped` gets what had no place, a line each; it may
   be NULL. */
WEFT_C_API weft_status weft_convert(const char* input, const char* output, const char* solution,
                                    const weft_write_settings* settings, weft_text** dropped);

/* ----------------------------------------------------------------------------------------------- Metrics */

/* Which of the components of a symmetric tensor is where. */
typedef WEFT_C_ENUM(weft_tensor_order){
    WEFT_ORDER_SOL = 1,  /* 11 12 22 13 23 33: as in .sol files and in <weft/weft.h> */
    WEFT_ORDER_ROWS = 2, /* 11 12 13 22 23 33: the upper triangle row by row, as in Mmg's interface */
    WEFT_ORDER_VOIGT = 3 /* 11 22 33 23 13 12 */
} weft_tensor_order;

/* Metric tensors at `count` vertices, or wanted sizes (the same in all directions). */
WEFT_C_API weft_status weft_metric_from_tensors(int64_t count, const double* tensors, weft_tensor_order order,
                                                weft_metric** metric);
WEFT_C_API weft_status weft_metric_from_sizes(int64_t count, const double* sizes, weft_metric** metric);
/* From a file of sizes or tensors, for a mesh. */
WEFT_C_API weft_status weft_metric_read(const char* path, const weft_mesh* mesh, weft_metric** metric);
WEFT_C_API weft_status weft_metric_write(const weft_metric* metric, const char* path);
/* The metric that options ask for: of solutions, of the boundary, of `source` (may be NULL); limited, graded,
   scaled. */
WEFT_C_API weft_status weft_metric_make(const weft_mesh* mesh, const weft_metric* source,
                                        const weft_options* options, weft_metric** metric);
/* The same, with what there is to warn of, a line each, to be freed: a complexity that limits keep out of
   reach, for instance. `warnings` may be NULL. */
WEFT_C_API weft_status weft_metric_make_with(const weft_mesh* mesh, const weft_metric* source,
                                             const weft_options* options, weft_metric** metric,
                                             weft_text** warnings);
WEFT_C_API weft_status weft_metric_count(const weft_metric* metric, int64_t* count);
/* Copies the tensors to where `capacity` numbers have room. */
WEFT_C_API weft_status weft_metric_get(const weft_metric* metric, weft_tensor_order order, int64_t capacity,
                                       double* tensors);
/* About half the vertices of a mesh that conforms to the metric. */
WEFT_C_API weft_status weft_metric_complexity(const weft_mesh* mesh, const weft_metric* metric,
                                              double* complexity);

/* ------------------------------------------------------------------------------------------------ Fields */

/* Fields at the vertices of a mesh; without any, at first. */
WEFT_C_API weft_status weft_fields_create(int64_t num_points, weft_fields** fields);
/* Adds one of 1 (scalar), 3 (vector) or 6 (symmetric tensor, WEFT_ORDER_SOL) components. */
WEFT_C_API weft_status weft_fields_add(weft_fields* fields, const char* name, int components,
                                       const double* values);
WEFT_C_API weft_status weft_fields_count(const weft_fields* fields, int64_t* num_fields, int64_t* num_points);
/* Any of the outputs may be NULL. The pointers are valid until the fields are freed or changed, as by adding
   one or by a repair. */
WEFT_C_API weft_status weft_fields_get(const weft_fields* fields, int64_t index, const char** name,
                                       int* components, const double** values);
WEFT_C_API weft_status weft_fields_read(const char* path, weft_fields** fields);
WEFT_C_API weft_status weft_fields_write(const weft_fields* fields, const char* path);
/* Fields of one mesh at the vertices of another. Options may be NULL: transfer and threads are read. */
WEFT_C_API weft_status weft_interpolate(const weft_mesh* from, const weft_fields* fields, const weft_mesh* to,
                                        const weft_options* options, weft_fields** result);

/* What became of one component of a field that was transferred. */
typedef struct weft_component_account {
  size_t size;      /* sizeof(weft_component_account), to be set by the caller */
  const char* name; /* of the field, with " 1", " 2", ... where it has several; valid while the fields are */
  double integral_before, integral_after;
  double absolute;               /* the integral of the old |field|: the scale of both */
  double difference_l2, norm_l2; /* after interpolation back to the old mesh; the old field's own */
  double difference_max, norm_max;
  double beyond_bounds; /* conservative: the most by which a value left the bounds of the old ones */
} weft_component_account;
/* Of fields that weft_interpolate() has made; `index` counts the components of all fields from 0. */
WEFT_C_API weft_status weft_fields_account(const weft_fields* fields, int64_t index,
                                           weft_component_account* account);
/* Of the same: vertices outside the old mesh, which have the values of its closest point, and how far the
   farthest is. Either may be NULL. */
WEFT_C_API weft_status weft_fields_outside(const weft_fields* fields, int64_t* vertices, double* farthest);

/* ----------------------------------------------------------------------------------------------- Options */

/* The options that programs set most, by name: the meaning and the default of each are those of the command.
   Start from weft_settings_default(): `size` tells a later library how much of it the caller knows. */
typedef struct weft_settings {
  size_t size; /* sizeof(weft_settings) */
  double complexity, hmin, hmax, aspect, hgrad;
  double curvature, sagitta, ridge_angle, hausd, norm;
  int32_t threads, subdomains;
  int32_t implied, conservative, ghosts, force; /* 0: no, 1: yes */
} weft_settings;
/* Fills the first settings->size bytes. */
WEFT_C_API weft_status weft_settings_default(weft_settings* settings);

/* `settings` may be NULL: all defaults. */
WEFT_C_API weft_status weft_options_create(const weft_settings* settings, weft_options** options);
/* By the command's names without dashes ("hgrad-space"), to what the command line would have; see
   weft_option_name(). Which values make sense is said when they are used. */
WEFT_C_API weft_status weft_options_set(weft_options* options, const char* name, const char* value);
WEFT_C_API weft_status weft_options_set_number(weft_options* options, const char* name, double value);
/* The names that there are, from 0 on; NULL behind the last. `type` and `text` say what each is, and may be
   NULL. */
WEFT_C_API const char* weft_option_name(int64_t index, const char** type, const char** text);
/* The scalar fields of a solution drive the metric. */
WEFT_C_API weft_status weft_options_add_solution(weft_options* options, const weft_fields* solution);

/* How far a run is. */
typedef struct weft_progress {
  size_t size;       /* of what the library has filled */
  const char* stage; /* "collapse", "measuring", or a sentence with counts */
  double done;       /* predicted share of the time, 0 to 1 */
  uint64_t tets;     /* now; 0: not known */
} weft_progress;
/* Returns 0 to cancel: the run ends soon with the valid mesh that it has. */
typedef int (*weft_progress_function)(void* user, const weft_progress* progress);
/* Called on the calling thread of rank 0, a few times a second; NULL: no more. */
WEFT_C_API weft_status weft_options_set_progress(weft_options* options, weft_progress_function function,
                                                 void* user);
/* Cancels the runs that these options have been given to: from another thread or from a signal handler of a
   program that keeps the options until the run has ended; on several ranks on all of them. 0 as `cancel`
   makes the options usable again. */
WEFT_C_API weft_status weft_options_cancel(weft_options* options, int cancel);
/* Asks the run that these options have been given to for a checkpoint now (option checkpoint: its folder):
   from another thread, or from a signal handler as above; on several ranks on any of them. */
WEFT_C_API weft_status weft_options_checkpoint(weft_options* options);

/* -------------------------------------------------------------------------------------------- Adaptation */

/* Adapts a mesh. `metric`: at its vertices; NULL: the one that options make. `options` may be NULL. `fields`,
   at its vertices, are carried along; NULL: none. */
WEFT_C_API weft_status weft_adapt(const weft_mesh* mesh, const weft_metric* metric,
                                  const weft_options* options, const weft_fields* fields,
                                  weft_result** result);
/* To a metric that belongs to another mesh of the same domain. `metric`: at the vertices of `background`;
   NULL: the one that options make there, of solutions at its vertices for instance. `fields` are at those of
   `mesh`. */
WEFT_C_API weft_status weft_adapt_to_background(const weft_mesh* mesh, const weft_mesh* background,
                                                const weft_metric* metric, const weft_options* options,
                                                const weft_fields* fields, weft_result** result);
/* From file to file, as `weft adapt IN -o OUT` does. Under mpirun it is a call of all ranks, which starts and
   ends MPI: only one such call can be made. A program that makes several calls MPI_Init before the first and
   MPI_Finalize after the last. */
WEFT_C_API weft_status weft_adapt_files(const char* input, const char* output, const weft_options* options,
                                        weft_result** result);

/* What `weft adapt` is told of files beside the options. Texts that are NULL mean none. */
typedef struct weft_file_settings {
  size_t size;               /* sizeof(weft_file_settings) */
  const char* background;    /* the mesh that the metric belongs to; NULL: the input */
  const char* const* fields; /* files of fields at the vertices of the input, carried along */
  int64_t num_fields;
  const char* report; /* folder for report.json and, unless page is 0, report.html, profile.json and (in
                         subdomains) graph.json */
  int32_t page;
  const char* case_name;        /* published figures to show beside */
  const char *graph, *trace;    /* files for the task graph and for a timeline: in subdomains */
  int32_t simulate_ranks;       /* so many ranks that this thread simulates; 0: none */
  const char* simulate_network; /* "2us,10GB/s" */
  double simulate_slowdown;
  int32_t simulate_cores; /* that their threads share; 0: one each */
} weft_file_settings;
WEFT_C_API weft_status weft_file_settings_default(weft_file_settings* settings);
WEFT_C_API weft_status weft_adapt_files_with(const char* input, const char* output,
                                             const weft_file_settings* settings, const weft_options* options,
                                             weft_result** result);

/* What one rank has of a mesh in parts: a mesh of its own (which the part takes, copying nothing, unless it
   is shared; the handle stays valid), the global ids of its points, the same wherever a point is, and, or
   NULL, those of its tets, which fix their order, and fields at its points. A mesh may be empty. */
WEFT_C_API weft_status weft_part_create(weft_mesh* mesh, const int64_t* point_ids, const int64_t* tet_ids,
                                        const weft_fields* fields, weft_part** part);
/* Adapts a mesh in parts. All ranks of the communicator call it; all return the same status. A rank whose own
   preparations have failed passes NULL as its part, so that nobody waits for it. `metric`: at the points of
   the part, or NULL on all ranks: options make one, of solutions at the points of the parts for instance. */
WEFT_C_API weft_status weft_adapt_parts(MPI_Comm communicator, const weft_part* part,
                                        const weft_metric* metric, const weft_options* options,
                                        weft_result** result);
/* The same with a communicator of Fortran's, which is also what py2f() of mpi4py gives. */
WEFT_C_API weft_status weft_adapt_parts_f(int communicator, const weft_part* part, const weft_metric* metric,
                                          const weft_options* options, weft_result** result);
/* To a metric at the points of another mesh of the same domain, which is in parts too: any tets of it may be
   on any rank. `metric`: at the points of `background`, or NULL on all ranks: options make one there. What is
   wrong with it is said with "background: " before the rank. */
WEFT_C_API weft_status weft_adapt_parts_to_background(MPI_Comm communicator, const weft_part* part,
                                                      const weft_part* background, const weft_metric* metric,
                                                      const weft_options* options, weft_result** result);
WEFT_C_API weft_status weft_adapt_parts_to_background_f(int communicator, const weft_part* part,
                                                        const weft_part* background,
                                                        const weft_metric* metric,
                                                        const weft_options* options, weft_result** result);
WEFT_C_API weft_status weft_part_mesh(const weft_part* part, weft_mesh** mesh);
WEFT_C_API weft_status weft_part_fields(const weft_part* part, weft_fields** fields);
/* Of a result's part: the ids of its points, counting from 0 without gaps, and the rank that owns each. */
WEFT_C_API weft_status weft_part_points(const weft_part* part, const uint64_t** ids, const int** owners);
/* Tets from this one on are ghosts; which rank has each of them (NULL where there are none). */
WEFT_C_API weft_status weft_part_ghosts(const weft_part* part, int64_t* num_own_tets, const int** owners);

/* ----------------------------------------------------------------------------------------------- Results */

/* New handles on what the result has, to be freed too; nothing is copied. */
WEFT_C_API weft_status weft_result_mesh(const weft_result* result, weft_mesh** mesh);
WEFT_C_API weft_status weft_result_metric(const weft_result* result, weft_metric** metric);
WEFT_C_API weft_status weft_result_fields(const weft_result* result, weft_fields** fields);
WEFT_C_API weft_status weft_result_part(const weft_result* result, weft_part** part);
/* Mesh, metric beside it, and fields, as `weft adapt` writes them. */
WEFT_C_API weft_status weft_result_write(const weft_result* result, const char* path);
/* A run that is ended early gives a whole mesh at once, without measuring it, as one does with the option
   measure=no. The goal (of a run that was not ended early), summary, JSON and measures take the measures when
   they are first asked for. A mesh in parts is measured by all ranks together or, with measure=no, not at
   all, and the goal then counts as not met. */

/* 1 or 0: whether the goal was met (else the summary says why), and whether the run was cancelled. Either may
   be NULL. */
WEFT_C_API weft_status weft_result_verdict(const weft_result* result, int* goal_met, int* cancelled);
/* What the command prints; the same for programs, JSON of schema weft-report-1. */
WEFT_C_API weft_status weft_result_summary(const weft_result* result, const char** text);
WEFT_C_API weft_status weft_result_json(const weft_result* result, const char** text);
/* What else there is to tell of a run. */
typedef WEFT_C_ENUM(weft_told){
    WEFT_WARNINGS = 0, /* such as triangles of the boundary that were missing and have been made */
    WEFT_MENDS = 1,    /* what repair has done to the input */
    WEFT_MISSED = 2,   /* why the goal was not met; takes the measures as above */
    WEFT_ENDED_BY = 3  /* of a cancelled run: interrupted, time limit, memory limit, out of memory */
} weft_told;
/* A line each, or an empty text; to be freed. */
WEFT_C_API weft_status weft_result_told(const weft_result* result, weft_told what, weft_text** text);
/* Of files: report.json, and what could not be written beside the mesh, and why (there is no report then);
   "" where there is none. Either may be NULL. */
WEFT_C_API weft_status weft_result_report(const weft_result* result, const char** report, const char** error);

/* Quality of tets (mean ratio) and lengths of edges in a metric. */
typedef struct weft_measures {
  size_t size; /* sizeof(weft_measures), to be set by the caller */
  int64_t vertices, tets, edges, triangles;
  double volume, complexity;
  double quality_mean, quality_min, quality_q01; /* q01: 1 % quantile */
  double length_mean, length_min, length_max;
  double edges_unit, edges_short, edges_long; /* shares */
} weft_measures;
/* Of the result, WEFT_MISUSE where one in parts or in files has not been measured; of any mesh. */
WEFT_C_API weft_status weft_result_measures(const weft_result* result, weft_measures* measures);
WEFT_C_API weft_status weft_measure(const weft_mesh* mesh, const weft_metric* metric,
                                    weft_measures* measures);
/* All that `weft stat --json` tells, with histograms: JSON of schema weft-stat-1. `metric` may be NULL, and
   `options` too: of them geometry and geometry-scale are read, a CAD model that the mesh is to lie on. */
WEFT_C_API weft_status weft_stat(const weft_mesh* mesh, const weft_metric* metric,
                                 const weft_options* options, weft_text** json);
/* Histograms of quality and length as a figure: .png, .svg or .pdf. */
WEFT_C_API weft_status weft_draw_histograms(const char* path, const weft_mesh* mesh,
                                            const weft_metric* metric);

/* A picture, by the words of `weft view`. Texts that are NULL ask for nothing. */
typedef struct weft_picture_settings {
  size_t size;          /* sizeof(weft_picture_settings) */
  const char* color_by; /* none, ref, subdomain, quality, length, nonconforming, field */
  const char* pixels;   /* WIDTHxHEIGHT */
  const char* from;     /* x, -x, ..., iso, AZIMUTH,ELEVATION */
  const char* up;
  const char* clip;
  const char* focus;
  const char* range;
  const char* title;
  const int32_t* only; /* references: only boundary triangles of these; NULL: of all */
  int64_t num_only;
  double zoom;
  double line_width;
  int32_t dark, flip, slice, edges, legend, axes; /* 0 or 1 */
} weft_picture_settings;
WEFT_C_API weft_status weft_picture_settings_default(weft_picture_settings* settings);
/* Draws a mesh into a .png, .svg or .pdf. `metric` may be NULL unless qualities or lengths colour it;
   `field`, if not NULL, has a value for each of the mesh's points and colours it. `settings` may be NULL. */
WEFT_C_API weft_status weft_draw(const char* path, const weft_mesh* mesh, const weft_metric* metric,
                                 const double* field, int64_t num_values,
                                 const weft_picture_settings* settings);

/* ---------------------------------------------------------------------------------------- Initial meshes */

typedef struct weft_fill_settings {
  size_t size;       /* sizeof(weft_fill_settings) */
  double growth;     /* of neighbouring edges away from the surface */
  double max_size;   /* 0: no limit */
  double merge;      /* points nearer than this share of the diagonal are one */
  int32_t materials; /* 1: a shell within a volume bounds a material, not a hole; so do voids of a model */
  int32_t remesh_surface; /* 1: the surface may be adapted */
} weft_fill_settings;
WEFT_C_API weft_status weft_fill_settings_default(weft_fill_settings* settings);
/* Fills the volumes that the closed triangles of a mesh bound with tets. `settings` and `options` may be
   NULL; of the options threads, time-limit, max-memory, repair, no-verify, ridge-angle and hausd are read,
   with remesh_surface geometry and geometry-scale too, and progress is told. A run that is ended early gives
   the valid mesh that it has; weft_fill_to_result() says so, and more. */
WEFT_C_API weft_status weft_fill(const weft_mesh* surface, const weft_fill_settings* settings,
                                 const weft_options* options, weft_mesh** mesh, weft_metric** metric);
/* The same with the sizes of another mesh: `sizes` at the vertices of `background`, instead of the surface's.
 */
WEFT_C_API weft_status weft_fill_to_background(const weft_mesh* surface, const weft_mesh* background,
                                               const weft_metric* sizes, const weft_fill_settings* settings,
                                               const weft_options* options, weft_mesh** mesh,
                                               weft_metric** metric);
/* The same as both (`background` and `sizes` may be NULL), with what there is to say of it: a result, of
   which weft_result_mesh(), _metric(), _write(), _verdict() (missed: it lies on the CAD model worse than the
   surface did), _measures() and _told() tell. It has no summary and no JSON. */
WEFT_C_API weft_status weft_fill_to_result(const weft_mesh* surface, const weft_mesh* background,
                                           const weft_metric* sizes, const weft_fill_settings* settings,
                                           const weft_options* options, weft_result** result);
typedef struct weft_fill_account {
  size_t size;      /* sizeof(weft_fill_account), to be set by the caller */
  int64_t regions;  /* that have been filled */
  double deviation; /* of repair: largest distance of the mended surface from the one given */
  double grid_seconds, fill_seconds;
} weft_fill_account;
/* Of a result of weft_fill_to_result(). */
WEFT_C_API weft_status weft_result_fill(const weft_result* result, weft_fill_account* account);
/* Triangles on a CAD model, to be filled; options: geometry, geometry-scale, and hausd as the largest
   distance of an edge from the model. `angle`: degrees that the normal turns along an edge; 0: 20. */
WEFT_C_API weft_status weft_tessellate(const weft_options* options, double angle, weft_mesh** surface);
/* The triangles of simple bodies, with edges of length `size`. Of the delta wing 0 means: as coarse as
 * possible. */
WEFT_C_API weft_status weft_ball_surface(double radius, const double center[3], double size,
                                         weft_mesh** surface);
WEFT_C_API weft_status weft_cylinder_surface(double radius, double height, const double base[3], double size,
                                             weft_mesh** surface);
WEFT_C_API weft_status weft_delta_wing_surface(double size, weft_mesh** surface);

/* ----------------------------------------------------------------------------------------- Recorded runs */

/* Another machine, for the task graph of a run; the texts as those of `weft replay`. */
typedef struct weft_replay_settings {
  size_t size; /* sizeof(weft_replay_settings) */
  int32_t ranks;
  int32_t threads;     /* a rank; a task takes one */
  const char* network; /* LATENCY,BANDWIDTH[,TOPOLOGY] */
  const char* balancer;
  double slowdown;         /* of every task */
  double grow;             /* so many times the tets in each subdomain */
  int64_t subdomain_bytes; /* memory of one; 0: by the recording */
  int32_t processor_times; /* 1: tasks take their processor time */
  int32_t copies;          /* so many times the recorded mesh */
  int32_t split;           /* so many times the subdomains of the mesh */
  int32_t unused;
  const char* report;  /* folder; NULL: none. So are the next two, which are files. */
  const char* account; /* what `json` gives */
  const char* trace;   /* a timeline */
} weft_replay_settings;
WEFT_C_API weft_status weft_replay_settings_default(weft_replay_settings* settings);
/* `graph`: graph.json or profile.json of a run. `settings` may be NULL. `summary` and `json` (either may be
   NULL) are the account for people and for programs (schema weft-replay-1). */
WEFT_C_API weft_status weft_replay(const char* graph, const weft_replay_settings* settings,
                                   weft_text** summary, weft_text** json);

/* What of a task graph is shown. */
typedef struct weft_graph_filter {
  size_t size;           /* sizeof(weft_graph_filter) */
  int64_t round;         /* only runs of this round; -1: of all. So is the next. */
  int64_t subdomain;     /* from 0 */
  const char* collapse;  /* none, rounds, subdomains: what is one vertex */
  int32_t critical_path; /* 1: only that */
  int32_t plan;          /* 1: the planned graph, which is the same for every subdomain */
} weft_graph_filter;
WEFT_C_API weft_status weft_graph_filter_default(weft_graph_filter* filter);
/* The task graph of a run (graph.json, profile.json) as dot, graphml, json or svg. `filter` may be NULL. */
WEFT_C_API weft_status weft_graph_text(const char* path, const char* format, const weft_graph_filter* filter,
                                       weft_text** text);

/* Writes the page of a run's profile.json. */
WEFT_C_API weft_status weft_report_page(const char* profile, const char* page);
/* What got slower from run `a` to run `b` (profile.json or report.json), and how the meshes differ; as a page
   too, unless `page` is NULL. */
WEFT_C_API weft_status weft_compare_reports(const char* a, const char* b, const char* page, weft_text** text);

#ifdef __cplusplus
}
#endif

#endif

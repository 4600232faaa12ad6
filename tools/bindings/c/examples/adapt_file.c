/* Adapts a mesh to a metric, both from files: adapt_file IN.meshb METRIC.solb OUT.meshb */
#include <stdio.h>
#include <weft/weft-c.h>

static int show(void* user, const weft_progress* now) {
  if (user && now->done >= 0) fprintf((FILE*)user, "%s: %.0f %%\n", now->stage, 100 * now->done);
  return 1; /* 0 would end the run with the mesh that it has */
}

int main(int argc, char** argv) {
  weft_mesh* mesh = NULL;
  weft_metric* metric = NULL;
  weft_options* options = NULL;
  weft_result* result = NULL;
  const char* summary = "";
  if (argc != 4) return 2;

  weft_settings settings = {.size = sizeof settings};
  weft_status status = weft_settings_default(&settings);
  settings.threads = 1; /* the same bytes every time */
  if (!status) status = weft_options_create(&settings, &options);
  if (!status) status = weft_options_set(options, "hgrad", "1.5");
  if (!status) status = weft_options_set_progress(options, show, stderr);
  if (!status) status = weft_mesh_read(argv[1], &mesh);
  if (!status) status = weft_metric_read(argv[2], mesh, &metric);
  if (!status) status = weft_adapt(mesh, metric, options, NULL, &result);
  if (!status) status = weft_result_write(result, argv[3]);
  if (!status) status = weft_result_summary(result, &summary);
  if (status) fprintf(stderr, "%s: %s\n", weft_status_name(status), weft_last_error());
  printf("%s", summary);

  weft_free(result);
  weft_free(options);
  weft_free(metric);
  weft_free(mesh);
  return status ? 1 : 0;
}

#include "setup/options.h"
#include "base/host.h"
#include "base/linear.h"
#include "base/parse.h"
#include "scene/camera_json.h"
#include "setup/config_json.h"
#include "setup/presets.h"
#include "truth/truth.h"
#include <math.h>
#include <string.h>
#include <unistd.h>

const char *const host_backend_names[HOST_BACKENDS] = {"vulkan", "d3d12"};

static const char help[] =
    "csm-host: draws cascaded shadows on both backends and compares them\n"
    "\n"
    "  csm-host run    [options]   draw one frame on each backend, compare, write pictures\n"
    "  csm-host measure [options]  draw one frame on each backend, and measure it against the truth\n"
    "  csm-host bench  [options]   time the passes of each backend against bare loops, in turn\n"
    "  csm-host report [options]   sweep configurations: a page on error against time, DIR/report.html and .json\n"
    "  csm-host hard   [options]   the hard cases: where shadows break, with figures that must hold\n"
    "  csm-host view   [options]   fly through the scene in a window; H there tells the keys\n"
    "  csm-host config             every key of a configuration with its unit, range and default, as JSON; with\n"
    "                              --preset or --config, that configuration\n"
    "  csm-host presets            every preset: what it is, where it was read, what was taken where nothing is said\n"
    "  csm-host --help\n"
    "\n"
    "  --scene NAME|FILE           valley (default), town, oaks, or a .gltf or .glb file; report and measure "
    "--presets:\n"
    "                              any number of them, one --scene each; report: if none is named, valley, town and, "
    "where they are there, oaks\n"
    "  --camera px,py,pz:tx,ty,tz:vfov_deg[:near:far]   or a JSON file like a dump's frame.json\n"
    "  --light x,y,z[:disc_deg]    the way the light travels, and the sun's apparent diameter\n"
    "  --shadow-distance m         view depth up to which shadows matter\n"
    "  --size WxH                  pixels; 1280x720\n"
    "  --config FILE.json          keys as `csm-host config` lists them; the rest keeps its default\n"
    "  --preset NAME               a configuration by name, as `csm-host presets` lists them; --config goes over it\n"
    "  --presets all|LIST          measure: compares these with the configuration: a table of errors and times;\n"
    "                              report: what joins the sweep under a soft sun; all\n"
    "  --against LIST              measure --presets: holds them against the best of these, the textbook's\n"
    "  --suns LIST                 report, measure --presets: the sun's diameters in degrees, 0 for a hard one, each "
    "by\n"
    "                              itself; the light's own\n"
    "  --backend vulkan|d3d12|both both is the default\n"
    "  --device NAME               part of the device's name\n"
    "  --out DIR                   run: where lit, mask, cascades, density, maps, frusta, culled,\n"
    "                              penumbra (of soft filters), rays (of exact ones) and\n"
    "                              difference.png go; out. Where the backends differ, the\n"
    "                              second one's pictures lie beside them, with its name before each;\n"
    "                              hard: where a picture of each case's worst pixel goes, if it is given\n"
    "  --json FILE|-               the numbers as JSON\n"
    "  --dump DIR                  geometry, matrices, maps and masks of each backend\n"
    "  --cache DIR                 measure, report: where truths are kept; $XDG_CACHE_HOME/csm or ~/.cache/csm\n"
    "  --camera-path FILE          measure: a JSON list of cameras, each as --camera takes them (text, or an object\n"
    "                              like frame.json's), drawn one after the other\n"
    "  --light-path FILE|day:N     measure: likewise, of lights; N of a day and a night\n"
    "  --sun-samples N             measure, report: rays to a soft sun for each pixel, 4 to 4096; 256\n"
    "  --quick                     bench, report, measure --presets: 5 pairs instead of 31; report: 1, 2 and 4 maps of "
    "512 to 2048\n"
    "  --only PART                 bench: depth (the maps' frame, planning, switching), floors, filters, modes, maps,\n"
    "                              casters (what caster_set view leaves out), moments, drawn (moments written while\n"
    "                              casters are drawn; moments has it, too), bare (the 7 x 7 filter against 49\n"
    "                              comparisons), rays (exact shadows: trees, rays, masks, instances that move), or\n"
    "                              pages (maps that are kept, against whole ones: what moves, and what does not);\n"
    "                              all of them if none is named\n"
    "  --cascades LIST             report: numbers of maps; 1,2,3,4,5,6,7,8\n"
    "  --resolutions LIST          report: texels a side; 512,1024,2048,4096\n"
    "  --minutes M                 report, measure --presets: after one round of all it draws again only while that "
    "ends in time; 30\n"
    "  --case NAME,NAME|none       hard, report: these hard cases; all of them if none is named\n"
    "  --long                      hard, report: every value of them, not some: minutes\n"
    "  --table                     hard: print the figures as tables in Markdown\n"
    "  --frames N --keys TEXT      view: N frames, a key of TEXT pressed in each ('.' is none); saves view.png\n"
    "\n"
    "Exit codes: 0 the backends agree, 1 they differ, 2 bad input, 3 no device or backend.\n";

void options_print_help(FILE *to) {
  fputs(help, to);
}

static int fail_with_text(const json_source *from, const char *problem, const char *text) {
  char message[512];
  snprintf(message, sizeof message, "%s: '%s'", problem, text);
  return json_source_fail(from, NULL, message);
}

int light_from_text(scene_light *out, const char *text, const json_source *from) {
  const char *colon = strchr(text, ':');
  char direction[256];
  const int length = (int)(colon ? (size_t)(colon - text) : strlen(text));
  if ((size_t)snprintf(direction, sizeof direction, "%.*s", length, text) >= sizeof direction ||
      parse_numbers(direction, ',', out->direction, 3) != 3)
    return fail_with_text(from, "not x,y,z[:disc_deg]", text);
  if (vec_length(out->direction) == 0.0)
    return json_source_fail(from, NULL, "the direction must not be zero");
  out->disc_deg = 0.0;
  if (colon && (!parse_number(colon + 1, &out->disc_deg) || out->disc_deg < 0.0 || out->disc_deg >= 180.0))
    return fail_with_text(from, "the disc must be 0 to 180 degrees", colon + 1);
  return 0;
}

static int parse_light(host_options *out, const char *value) {
  out->has_light = true;
  return light_from_text(&out->light, value, &(json_source){.name = "--light"});
}

static int parse_shadow_distance(host_options *out, const char *value) {
  if (!parse_number(value, &out->shadow_distance) || !(out->shadow_distance > 0.0))
    return host_fail(HOST_BAD_INPUT, "--shadow-distance: not a positive number of metres: '%s'", value);
  out->has_shadow_distance = true;
  return 0;
}

static int parse_picture_size(host_options *out, const char *value) {
  if (!parse_size(value, &out->width, &out->height))
    return host_fail(HOST_BAD_INPUT, "--size: not WxH with 1 to 16384 pixels a side: '%s'", value);
  out->has_size = true;
  return 0;
}

static int parse_backend(host_options *out, const char *value) {
  bool known = false;
  for (int i = 0; i < HOST_BACKENDS; i++) {
    out->backends[i] = strcmp(value, "both") == 0 || strcmp(value, host_backend_names[i]) == 0;
    known = known || out->backends[i];
  }
  return known ? 0 : host_fail(HOST_BAD_INPUT, "--backend: not vulkan, d3d12 or both: '%s'", value);
}

static int parse_frames(host_options *out, const char *value) {
  double frames;
  if (!parse_number(value, &frames) || frames != floor(frames) || frames < 1.0 || frames > 1e6)
    return host_fail(HOST_BAD_INPUT, "--frames: not a whole number from 1 to 1000000: '%s'", value);
  out->frames = (uint32_t)frames;
  return 0;
}

static int parse_preset(host_options *out, const char *value) {
  out->preset = preset_find("--preset", value);
  return out->preset ? 0 : HOST_BAD_INPUT;
}

static int add_preset(options_presets *out, const char *option, const char *name) {
  const char *found = preset_find(option, name);
  if (!found)
    return HOST_BAD_INPUT;
  for (uint32_t i = 0; i < out->count; i++)
    if (out->names[i] == found)
      return host_fail(HOST_BAD_INPUT, "%s: '%s' is named twice", option, name);
  if (out->count == OPTIONS_MAX_PRESETS)
    return host_fail(HOST_BAD_INPUT, "%s: more than %d", option, OPTIONS_MAX_PRESETS);
  out->names[out->count++] = found;
  return 0;
}

static int parse_preset_list(options_presets *out, const char *option, const char *value) {
  const bool all = strcmp(value, "all") == 0;
  char names[2048], *rest = NULL;
  int code = 0;
  out->count = 0;
  for (uint32_t i = 0; all && code == 0 && preset_name(i); i++)
    code = add_preset(out, option, preset_name(i));
  if (all || code)
    return code;
  if ((size_t)snprintf(names, sizeof names, "%s", value) >= sizeof names)
    return host_fail(HOST_BAD_INPUT, "%s: too long", option);
  const char *name = strtok_r(names, ",", &rest);
  do
    code = add_preset(out, option, name ? name : "");
  while (code == 0 && (name = strtok_r(NULL, ",", &rest)));
  return code;
}

static int parse_presets(host_options *out, const char *value) {
  return parse_preset_list(&out->presets, "--presets", value);
}

static int parse_against(host_options *out, const char *value) {
  return parse_preset_list(&out->against, "--against", value);
}

static int parse_suns(host_options *out, const char *value) {
  bool good = true;
  out->sun_count = parse_numbers(value, ',', out->suns, OPTIONS_MAX_SUNS);
  for (uint32_t i = 0; i < out->sun_count; i++) {
    good = good && out->suns[i] >= 0.0 && out->suns[i] < 180.0;
    for (uint32_t k = 0; k < i; k++)
      good = good && out->suns[i] != out->suns[k];
  }
  return good && out->sun_count > 0
             ? 0
             : host_fail(HOST_BAD_INPUT,
                         "--suns: not up to %d different diameters, 0 to 180 degrees, with commas: '%s'",
                         OPTIONS_MAX_SUNS, value);
}

static int parse_sun_samples(host_options *out, const char *value) {
  double count;
  if (!parse_number(value, &count) || !(count >= 4.0 && count <= TRUTH_MAX_SUN_SAMPLES) || count != floor(count))
    return host_fail(HOST_BAD_INPUT, "--sun-samples: not 4 to %d rays: '%s'", TRUTH_MAX_SUN_SAMPLES, value);
  out->sun_samples = (uint32_t)count;
  return 0;
}

static int parse_only(host_options *out, const char *value) {
  static const char *const parts[] = {"depth",   "floors", "filters", "modes", "maps", "casters",
                                      "moments", "drawn",  "bare",    "rays",  "pages"};
  out->only = value;
  for (size_t i = 0; i < sizeof parts / sizeof parts[0]; i++)
    if (strcmp(value, parts[i]) == 0)
      return 0;
  return host_fail(
      HOST_BAD_INPUT,
      "--only: not depth, floors, filters, modes, maps, casters, moments, drawn, bare, rays or pages: '%s'", value);
}

static int parse_scene(host_options *out, const char *value) {
  if (out->scene_count == OPTIONS_MAX_SCENES)
    return host_fail(HOST_BAD_INPUT, "--scene: more than %d scenes", OPTIONS_MAX_SCENES);
  out->scene = value;
  out->scenes[out->scene_count++] = value;
  return 0;
}

static bool add_once(options_list *list, uint32_t value) {
  for (uint32_t i = 0; i < list->count; i++)
    if (list->values[i] == value)
      return false;
  list->values[list->count++] = value;
  return true;
}

static int parse_list(options_list *out, const char *name, const char *value, uint32_t minimum, uint32_t maximum) {
  double numbers[OPTIONS_MAX_LIST];
  const uint32_t count = parse_numbers(value, ',', numbers, OPTIONS_MAX_LIST);
  bool good = count > 0;
  *out = (options_list){0};
  for (uint32_t i = 0; good && i < count; i++)
    good = numbers[i] == floor(numbers[i]) && numbers[i] >= minimum && numbers[i] <= maximum &&
           add_once(out, (uint32_t)numbers[i]);
  return good ? 0
              : host_fail(HOST_BAD_INPUT, "%s: not up to %d different whole numbers from %u to %u, with commas: '%s'",
                          name, OPTIONS_MAX_LIST, minimum, maximum, value);
}

static int parse_cascades(host_options *out, const char *value) {
  return parse_list(&out->cascades, "--cascades", value, 1, CSM_MAX_CASCADES);
}

static int parse_resolutions(host_options *out, const char *value) {
  return parse_list(&out->resolutions, "--resolutions", value, 16, 16384);
}

static int parse_cases(host_options *out, const char *value) {
  char *rest = NULL;
  out->case_count = 0;
  if ((size_t)snprintf(out->case_names, sizeof out->case_names, "%s", value) >= sizeof out->case_names)
    return host_fail(HOST_BAD_INPUT, "--case: too long");
  for (const char *name = strtok_r(out->case_names, ",", &rest); name; name = strtok_r(NULL, ",", &rest)) {
    if (out->case_count == OPTIONS_MAX_CASES)
      return host_fail(HOST_BAD_INPUT, "--case: more than %d", OPTIONS_MAX_CASES);
    out->cases[out->case_count++] = name;
  }
  return out->case_count ? 0 : host_fail(HOST_BAD_INPUT, "--case: no name: '%s'", value);
}

static int parse_out(host_options *out, const char *value) {
  out->out = value;
  out->has_out = true;
  return 0;
}

static int parse_minutes(host_options *out, const char *value) {
  if (!parse_number(value, &out->minutes) || !(out->minutes > 0.0))
    return host_fail(HOST_BAD_INPUT, "--minutes: not a positive number: '%s'", value);
  return 0;
}

/* An option that keeps its text, or one with a function that understands it. */
typedef struct option {
  const char *name;
  int (*parse)(host_options *out, const char *value);
  const char **text;
} option;

static int parse_option(host_options *out, const char *name, const char *value) {
  const option known[] = {{"--scene", parse_scene, NULL},
                          {"--camera", NULL, &out->camera_text},
                          {"--light", parse_light, NULL},
                          {"--shadow-distance", parse_shadow_distance, NULL},
                          {"--size", parse_picture_size, NULL},
                          {"--config", NULL, &out->config_file},
                          {"--preset", parse_preset, NULL},
                          {"--presets", parse_presets, NULL},
                          {"--against", parse_against, NULL},
                          {"--suns", parse_suns, NULL},
                          {"--backend", parse_backend, NULL},
                          {"--device", NULL, &out->device},
                          {"--out", parse_out, NULL},
                          {"--json", NULL, &out->json},
                          {"--dump", NULL, &out->dump},
                          {"--cache", NULL, &out->cache},
                          {"--camera-path", NULL, &out->camera_path},
                          {"--light-path", NULL, &out->light_path},
                          {"--sun-samples", parse_sun_samples, NULL},
                          {"--only", parse_only, NULL},
                          {"--cascades", parse_cascades, NULL},
                          {"--resolutions", parse_resolutions, NULL},
                          {"--minutes", parse_minutes, NULL},
                          {"--case", parse_cases, NULL},
                          {"--frames", parse_frames, NULL},
                          {"--keys", NULL, &out->keys}};
  for (size_t i = 0; i < sizeof known / sizeof known[0]; i++) {
    if (strcmp(name, known[i].name) != 0)
      continue;
    if (!value || *value == '\0')
      return host_fail(HOST_BAD_INPUT, "%s: needs a value", name);
    if (known[i].parse)
      return known[i].parse(out, value);
    *known[i].text = value;
    return 0;
  }
  return host_fail(HOST_BAD_INPUT, "unknown option '%s'", name);
}

static int parse_command(host_options *out, const char *name) {
  static const char *const names[] = {
      [COMMAND_CONFIG] = "config",   [COMMAND_PRESETS] = "presets", [COMMAND_RUN] = "run",
      [COMMAND_MEASURE] = "measure", [COMMAND_BENCH] = "bench",     [COMMAND_REPORT] = "report",
      [COMMAND_HARD] = "hard",       [COMMAND_VIEW] = "view"};
  for (int i = COMMAND_CONFIG; i <= COMMAND_VIEW; i++)
    if (strcmp(name, names[i]) == 0) {
      out->command = (host_command)i;
      return 0;
    }
  return host_fail(HOST_BAD_INPUT,
                   "unknown command '%s' (run, measure, bench, report, hard, view, config, presets, --help)", name);
}

/* Options without a value. False: it is none of them. */
static bool parse_switch(host_options *out, const char *name) {
  bool *const known = strcmp(name, "--quick") == 0   ? &out->quick
                      : strcmp(name, "--long") == 0  ? &out->sweep
                      : strcmp(name, "--table") == 0 ? &out->markdown
                                                     : NULL;
  if (known)
    *known = true;
  return known != NULL;
}

/* What a report sweeps if nothing else is said. */
static void complete_sweep(host_options *out) {
  static const options_list cascades[] = {{{1, 2, 3, 4, 5, 6, 7, 8}, 8}, {{1, 2, 4}, 3}};
  static const options_list resolutions[] = {{{512, 1024, 2048, 4096}, 4}, {{512, 1024, 2048}, 3}};
  if (out->cascades.count == 0)
    out->cascades = cascades[out->quick];
  if (out->resolutions.count == 0)
    out->resolutions = resolutions[out->quick];
}

/* One sun is the light's; several are gone through where that makes sense. */
static int complete_suns(host_options *out) {
  const bool compares = out->command == COMMAND_MEASURE && out->presets.count > 0;
  out->has_disc = out->sun_count == 1;
  out->disc_deg = out->suns[0];
  if (out->sun_count > 1 && out->command != COMMAND_REPORT && !compares)
    return host_fail(HOST_BAD_INPUT, "--suns: only report and measure --presets take more than one");
  if (out->against.count > 0 && !compares)
    return host_fail(HOST_BAD_INPUT, "--against: only measure --presets holds something against it");
  return 0;
}

int options_parse(host_options *out, int count, char **arguments) {
  *out = (host_options){.scene = "valley",
                        .width = 1280,
                        .height = 720,
                        .backends = {true, true},
                        .out = "out",
                        .sun_samples = 256,
                        .keys = "",
                        .minutes = 30.0,
                        .arguments = arguments,
                        .argument_count = count};
  for (int i = 1; i < count; i++)
    if (strcmp(arguments[i], "--help") == 0 || strcmp(arguments[i], "-h") == 0)
      return 0;
  if (count < 2) {
    options_print_help(stderr);
    return HOST_BAD_INPUT;
  }
  int code = parse_command(out, arguments[1]);
  for (int i = 2; code == 0 && i < count; i++) {
    if (parse_switch(out, arguments[i]))
      continue;
    code = parse_option(out, arguments[i], i + 1 < count ? arguments[i + 1] : NULL);
    i++;
  }
  complete_sweep(out);
  return code ? code : complete_suns(out);
}

const char *options_base_name(const host_options *options) {
  return options->config_file ? "--config" : options->preset ? options->preset : "default";
}

/* ---- setting up ---- */

/* px,py,pz:tx,ty,tz:vfov_deg[:near:far]; what is not given is the scene's. */
static int pose_from_text(camera_pose *pose, const char *text, const json_source *from) {
  char parts[1024];
  char *part[6];
  uint32_t count = 0;
  if ((size_t)snprintf(parts, sizeof parts, "%s", text) >= sizeof parts)
    return json_source_fail(from, NULL, "too long");
  part[count++] = parts;
  for (char *at = parts; *at && count < 6; at++)
    if (*at == ':') {
      *at = '\0';
      part[count++] = at + 1;
    }
  if ((count != 3 && count != 5) || parse_numbers(part[0], ',', pose->position, 3) != 3 ||
      parse_numbers(part[1], ',', pose->target, 3) != 3 || !parse_number(part[2], &pose->vertical_fov_deg) ||
      (count == 5 && (!parse_number(part[3], &pose->near_depth) || !parse_number(part[4], &pose->far_depth))))
    return fail_with_text(from, "neither px,py,pz:tx,ty,tz:vfov_deg[:near:far] nor a file", text);
  return 0;
}

int camera_from_text(camera *out, const camera_pose *standard, const char *text, double aspect,
                     const json_source *from) {
  camera_pose pose = *standard;
  const int code = text ? pose_from_text(&pose, text, from) : 0;
  if (code)
    return code;
  const char *problem = camera_pose_check(&pose);
  if (problem)
    return json_source_fail(from, NULL, problem);
  camera_from_pose(out, &pose, aspect);
  return 0;
}

/* A file that is there, or a name that is meant to be one. */
static bool is_camera_file(const char *text) {
  const char *ending = strrchr(text, '.');
  return access(text, F_OK) == 0 || (ending && strcmp(ending, ".json") == 0);
}

static int setup_camera(host_setup *out, const host_options *options) {
  if (options->camera_text && is_camera_file(options->camera_text)) {
    uint32_t width = 0, height = 0;
    const int code = camera_from_json(&out->camera, &width, &height, options->camera_text);
    if (code == 0 && width > 0 && !options->has_size) {
      out->width = width;
      out->height = height;
    }
    return code;
  }
  return camera_from_text(&out->camera, &out->scene.camera, options->camera_text, (double)out->width / out->height,
                          &(json_source){.name = "--camera"});
}

int setup_load(host_setup *out, const host_options *options) {
  memset(out, 0, sizeof *out);
  host_progress("loading the scene");
  int code = scene_load(&out->scene, options->scene);
  host_progress("");
  if (code)
    return code;
  out->width = options->width;
  out->height = options->height;
  out->light = options->has_light ? options->light : out->scene.light;
  if (options->has_disc)
    out->light.disc_deg = options->disc_deg;
  out->shadow_distance = options->has_shadow_distance ? options->shadow_distance : out->scene.shadow_distance;
  code = setup_camera(out, options);
  if (code == 0)
    code = config_load(&out->config, options->preset, options->config_file, out->shadow_distance);
  return code;
}

void setup_free(host_setup *setup) {
  scene_free(&setup->scene);
}

#include "bench_context.h"

#include "bench_json.h"
#include "cli/report.h"
#include "engine.h"

#include <embree3/rtcore_config.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { LINE_SIZE = 512 }; // bytes of a line of the system's files; what is longer is cut

#if defined(NDEBUG)
static const char BUILD_TYPE[] = "release";
#else
static const char BUILD_TYPE[] = "debug";
#endif

// ---- the system's small files ----

/// The first line without its end; false when there is none.
static bool read_line(const char *path, char line[LINE_SIZE])
{
    FILE *file = fopen(path, "re");
    bool read = file != NULL && fgets(line, LINE_SIZE, file) != NULL;
    if (file != NULL) {
        (void)fclose(file);
    }
    line[read ? strcspn(line, "\n") : 0] = '\0';
    return read;
}

/// Value of the first line "key : value" of /proc/cpuinfo; "" when there is none.
static void read_processor(const char *key, char value[LINE_SIZE])
{
    FILE *file = fopen("/proc/cpuinfo", "re");
    value[0] = '\0';
    char line[LINE_SIZE];
    while (file != NULL && value[0] == '\0' && fgets(line, sizeof line, file) != NULL) {
        const char *colon = strchr(line, ':');
        if (colon != NULL && strncmp(line, key, strlen(key)) == 0) {
            colon += strspn(colon, ": \t");
            (void)snprintf(value, LINE_SIZE, "%.*s", (int)strcspn(colon, "\n"), colon);
        }
    }
    if (file != NULL) {
        (void)fclose(file);
    }
}

// ---- the machine ----

static double megahertz(void)
{
    char line[LINE_SIZE];
    if (read_line("/sys/devices/system/cpu/cpu0/cpufreq/cpuinfo_max_freq", line)) {
        return strtod(line, NULL) / 1e3; // the file has kHz
    }
    read_processor("cpu MHz", line);
    return strtod(line, NULL);
}

static bool is_scaling_enabled(long processors)
{
    bool enabled = false;
    for (long index = 0; index < processors && !enabled; ++index) {
        char path[128];
        char line[LINE_SIZE];
        (void)snprintf(path, sizeof path, "/sys/devices/system/cpu/cpu%ld/cpufreq/scaling_governor", index);
        enabled = read_line(path, line) && strcmp(line, "performance") != 0;
    }
    return enabled;
}

static int count_bits(const char *hexadecimal)
{
    static const char digits[] = "0123456789abcdef";
    int count = 0;
    for (; *hexadecimal != '\0'; ++hexadecimal) { // a comma stands between two words
        const char *digit = strchr(digits, *hexadecimal);
        count += digit == NULL ? 0 : __builtin_popcount((unsigned)(digit - digits));
    }
    return count;
}

/// "32K" in bytes.
static json_int_t size_of_text(const char *text)
{
    char *end;
    long long size = strtoll(text, &end, 10);
    return *end == 'K' ? size * 1024 : (*end == 'M' ? size * 1024 * 1024 : size);
}

/// NULL past the last cache.
static json_t *cache_of(int index)
{
    static const char *const names[] = {"type", "level", "size", "shared_cpu_map"};
    char lines[4][LINE_SIZE];
    for (size_t name = 0; name < sizeof names / sizeof names[0]; ++name) {
        char path[128];
        (void)snprintf(path, sizeof path, "/sys/devices/system/cpu/cpu0/cache/index%d/%s", index,
                       names[name]);
        if (!read_line(path, lines[name])) {
            return NULL;
        }
    }
    json_t *cache = json_object();
    json_object_set_new(cache, "type", bench_json_text(lines[0]));
    json_object_set_new(cache, "level", json_integer((json_int_t)strtol(lines[1], NULL, 10)));
    json_object_set_new(cache, "size", json_integer(size_of_text(lines[2])));
    json_object_set_new(cache, "num_sharing", json_integer(count_bits(lines[3])));
    return cache;
}

static json_t *caches(void)
{
    json_t *list = json_array();
    json_t *cache = cache_of(0);
    for (int index = 1; cache != NULL; ++index) {
        json_array_append_new(list, cache);
        cache = cache_of(index);
    }
    return list;
}

static json_t *load_average(void)
{
    json_t *list = json_array();
    char line[LINE_SIZE];
    char *rest = line;
    for (int index = 0; read_line("/proc/loadavg", line) && index < 3; ++index) {
        rest = index == 0 ? line : rest;
        json_array_append_new(list, bench_json_number(strtod(rest, &rest)));
    }
    return list;
}

/// ISO 8601 with the offset from UTC.
static json_t *date(void)
{
    char text[64];
    char offset[16];
    struct tm local;
    time_t now = time(NULL);
    (void)localtime_r(&now, &local);
    size_t length = strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%S", &local);
    (void)strftime(offset, sizeof offset, "%z", &local); // +hhmm
    (void)snprintf(text + length, sizeof text - length, "%.3s:%.2s", offset, offset + 3);
    return bench_json_text(text);
}

static json_t *available_isas(void)
{
    json_t *list = json_array();
    for (PercaleIsa isa = PERCALE_ISA_SSE2; isa <= PERCALE_ISA_AVX512; ++isa) {
        if (percale_engine_for(isa) != NULL) {
            json_array_append_new(list, bench_json_text(percale_isa_name(isa)));
        }
    }
    return list;
}

/// What a solver chooses here.
static json_t *chosen_isa(void)
{
    PercaleSolver *solver = NULL;
    if (percale_solver_create(percale_solver_def_default(), &solver) != PERCALE_OK) {
        return bench_json_text("");
    }
    json_t *isa = bench_json_text(percale_isa_name(percale_solver_isa(solver)));
    percale_solver_destroy(solver);
    return isa;
}

static json_t *compiler(void)
{
    char text[64];
#if defined(__clang__)
    (void)snprintf(text, sizeof text, "clang %d.%d.%d", __clang_major__, __clang_minor__,
                   __clang_patchlevel__);
#else
    (void)snprintf(text, sizeof text, "gcc %d.%d.%d", __GNUC__, __GNUC_MINOR__, __GNUC_PATCHLEVEL__);
#endif
    return bench_json_text(text);
}

static void add_machine(json_t *context)
{
    char text[LINE_SIZE] = "";
    long processors = sysconf(_SC_NPROCESSORS_ONLN);
    (void)gethostname(text, sizeof text - 1);
    json_object_set_new(context, "host_name", bench_json_text(text));
    json_object_set_new(context, "num_cpus", json_integer(processors));
    json_object_set_new(context, "mhz_per_cpu", json_integer((json_int_t)megahertz()));
    json_object_set_new(context, "cpu_scaling_enabled", json_boolean(is_scaling_enabled(processors)));
    json_object_set_new(context, "caches", caches());
    json_object_set_new(context, "load_avg", load_average());
    read_processor("model name", text);
    json_object_set_new(context, "cpu", bench_json_text(text));
    json_object_set_new(context, "isa", chosen_isa());
    json_object_set_new(context, "isa_available", available_isas());
}

// ---- the user's own ----

/// "key=value[,key=value]..."
static void add_pairs(json_t *context, const char *text)
{
    while (*text != '\0') {
        size_t length = strcspn(text, ",");
        size_t key_length = strcspn(text, "=");
        char *key = strndup(text, key_length);
        char *value = strndup(text + key_length + 1, length - key_length - 1);
        if (key != NULL && value != NULL) {
            json_object_set_new(context, key, bench_json_text(value));
        }
        free(key);
        free(value);
        text += length;
        text += *text == ',';
    }
}

json_t *bench_context(const char *executable, const BenchFlags *flags)
{
    json_t *context = json_object();
    json_object_set_new(context, "date", date());
    json_object_set_new(context, "executable", bench_json_text(executable));
    add_machine(context);
    json_object_set_new(context, "library_build_type", bench_json_text(BUILD_TYPE));
    json_object_set_new(context, "compiler", compiler());
    json_object_set_new(context, "flags", bench_json_text(PERCALE_BENCH_FLAGS));
    json_object_set_new(context, "percale", bench_json_text(percale_version()));
    json_object_set_new(context, "embree", bench_json_text(RTC_VERSION_STRING));
    for (size_t index = 0; index < flags->contexts.count; ++index) {
        add_pairs(context, flags->contexts.items[index]);
    }
    return context;
}

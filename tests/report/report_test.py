"""csm-host report on a tiny scene: python3 report_test.py CSM_HOST BACKEND..."""
import html.parser
import json
import math
import os
import subprocess
import sys
import tempfile

from tiny_gltf import box, quad, write_gltf

host, backends = sys.argv[1], sys.argv[2:]
folder = tempfile.TemporaryDirectory()
at = lambda *names: os.path.join(folder.name, *names)
FILTERS = ('vsm', 'esm', 'evsm2', 'evsm4', 'msm4', 'pcss', 'backprojection',
           'pcf_2x2', 'pcf_3x3', 'nearest', 'linear_depth', 'pcf_5x5', 'pcf_7x7', 'pcf_n', 'poisson', 'vogel', 'grid_17',
           'exact', 'exact_soft')
BIAS_MODES = ('slope', 'receiver_plane')


def run(*arguments, code=0):
    command = [host, 'report', '--cache', at('cache'), *([] if '--case' in arguments else ['--case', 'none']), *arguments]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == code, (command, done.returncode, done.stderr)
    return done.stderr if code else done.stdout


class Page(html.parser.HTMLParser):
    """Checks that elements are closed in order and that nothing comes from elsewhere; keeps scripts' texts."""
    VOID = {'meta', 'link', 'br', 'img', 'input', 'hr'}

    def __init__(self, text):
        super().__init__()
        self.open, self.ids, self.scripts, self.found = [], set(), [], []
        self.feed(text)
        self.close()
        assert not self.open, self.open

    def handle_starttag(self, tag, attributes):
        attributes = dict(attributes)
        self.found.append(tag)
        assert attributes.get('id') not in self.ids or 'id' not in attributes, attributes
        self.ids.add(attributes.get('id'))
        for key in ('src', 'href', 'srcset'):
            assert attributes.get(key, 'data:').startswith('data:'), attributes
        if tag == 'script':
            self.scripts.append('')
        if tag not in self.VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open and self.open.pop() == tag, tag

    def handle_data(self, data):
        if self.open and self.open[-1] == 'script':
            self.scripts[-1] += data
        if self.open and self.open[-1] == 'style':
            assert 'url(' not in data and '@import' not in data


def is_soft(scene):
    return scene['light']['disc_deg'] > 0


def check_pictures(short, long, backend):
    """Of a hard sun those that were chosen; of a soft one the best of each filter."""
    if not is_soft(long):
        assert {p['point'] for p in short['pictures']} == {
            long['base'], *(long['verdicts'][backend][key] for key in ('knee', 'least_error'))}
        assert short['techniques'] == []
        return
    points = long['configurations']
    error = lambda i: points[i]['backends'][backend]['error']
    best = {f: min((i for i, p in enumerate(points) if p['filter'] == f), key=error) for f in {p['filter'] for p in points}}
    assert {p['point'] for p in short['techniques']} == set(best.values()) and short['pictures'] == []


def load(name):
    """A report's page and its JSON, which must agree."""
    with open(at(name, 'report.html'), encoding='utf-8') as file:
        text = file.read()
    page, full = Page(text), json.load(open(at(name, 'report.json')))
    data = json.loads(page.scripts[0])
    assert len(page.scripts) == 2 and '@DATA@' not in text
    assert {'svg', 'table', 'noscript', 'style'} <= set(page.found)
    assert [s['scene'] for s in data['scenes']] == [s['scene'] for s in full['scenes']]
    for short, long in zip(data['scenes'], full['scenes']):
        assert len(short['rows']) == len(long['configurations'])
        assert short['verdicts'] == long['verdicts']
        for row, configuration in zip(short['rows'], long['configurations']):
            assert all(configuration[key] == value for key, value in row[0].items())
            assert len(row[0]) == (6 if is_soft(long) else 4)
            assert len(row) == 3 + len(full['backends'])
        pictures = [p[kind] for p in short['pictures'] for kind in ('drawn', 'errors')] + [p['picture'] for p in short['techniques']]
        for uri in [short['truth_picture']] + pictures:
            assert uri.startswith('data:image/png;base64,iVBORw0KGgo') and len(uri) > 200
        check_pictures(short, long, full['backends'][0]['name'])
    what = lambda report: [(c['case'], c['about'], [(f['what'], f['holds']) for f in c['figures']]) for c in report['hard']]
    assert what(data) == what(full)
    assert all(c['picture'].startswith('data:image/png;base64,iVBORw0KGgo') and c['pictured'] for c in data['hard'])
    return full


def numbers(value):
    if isinstance(value, dict):
        return [n for v in value.values() for n in numbers(v)]
    if isinstance(value, list):
        return [n for v in value for n in numbers(v)]
    return [value] if isinstance(value, (int, float)) else []


def shape(configuration):
    return tuple(configuration[key] for key in ('cascade_count', 'resolution', 'filter', 'bias_mode'))


def check_scene(scene, shapes, rounds):
    points = scene['configurations']
    assert not is_soft(scene)
    small = min(r for _, r in shapes) < 128  # maps without room for what reaches 32 texels
    wanted = {(c, r, f, b) for c, r in shapes for f in FILTERS for b in BIAS_MODES
              if (f, b) not in (('linear_depth', 'receiver_plane'), ('exact', 'slope'), ('exact_soft', 'slope'))
              and not (small and f in ('pcss', 'backprojection', 'exact_soft'))}
    assert len(points) == len(wanted) and {shape(p) for p in points} == wanted
    check_points(scene, rounds)


def check_points(scene, rounds):
    points = scene['configurations']
    assert scene['rounds'] == rounds
    assert all(math.isfinite(n) for n in numbers(scene))
    for point in points:
        assert set(point['backends']) == set(backends)
        texel_bytes = 2 if point.get('name') == 'godot' else 4  # D16
        assert point['map_bytes'] >= texel_bytes * point['cascade_count'] * point['resolution'] ** 2
        for result in point['backends'].values():
            metrics, ms = result['metrics'], result['shadow_ms']
            wrong = metrics['false_lit'] + metrics['false_shadow']
            assert result['error'] == (metrics['rmse'] if is_soft(scene) else wrong)
            assert metrics['pixels'] > 2000 and wrong < 0.5, (scene['scene'], shape(point), metrics)
            assert 0 < ms['low'] <= ms['median'] <= ms['high']
            assert ms['median'] >= max(result[part]['median'] for part in ('plan_ms', 'gpu_ms')) * 0.5
            assert result['gpu_ms']['median'] >= max(result[part]['median'] for part in ('maps_ms', 'mask_ms')) * 0.5
        if len(backends) == 2:
            assert point['ratio']['low'] <= point['ratio']['median'] <= point['ratio']['high']
            assert point['differing_pixels'] == 0
    for backend in backends:
        check_verdict(scene, backend)


def check_verdict(scene, backend):
    """The front, its knee and the base's place, found anew."""
    verdict, base = scene['verdicts'][backend], scene['base']
    results = [p['backends'][backend] for p in scene['configurations']]
    time, least = ('gpu_ms', 1e-6) if is_soft(scene) else ('shadow_ms', 0)
    score = [(r[time]['median'], max(r['error'], least or 0.5 / r['metrics']['pixels'])) for r in results]
    beats = lambda a, b: a[0] <= b[0] and a[1] <= b[1] and a != b
    front = [i for i, s in enumerate(score) if not any(beats(t, s) for t in score)]
    front.sort(key=lambda i: score[i])
    assert verdict['front'] == front, (verdict, front)
    assert verdict['least_error'] == front[-1]
    first, last = score[front[0]], score[front[-1]]
    below = lambda i: sum((score[i][k] - (first, last)[k][k]) / ((last, first)[k][k] - (first, last)[k][k] or 1) for k in (0, 1))
    assert below(verdict['knee']) <= min(map(below, front)) + 1e-9
    assert verdict['base_error_rank'] == 1 + sum(s[1] < score[base][1] for s in score)
    assert verdict['base_time_rank'] == 1 + sum(s[0] < score[base][0] for s in score)


# A box on the ground, in a file with a name that would end a script.
ground = quad((-20, 0, -20), (-20, 0, 20), (20, 0, 20), (20, 0, -20))
name = "<!--</script>&'b.gltf".replace('/', '')
scene = write_gltf(at(name), ground + box((-1, 0, -1), (1, 2, 1)))
small = ['--scene', scene, '--size', '160x90', '--shadow-distance', '40', '--light', '0.5,-0.8,0.3', '--backend',
         'both' if len(backends) == 2 else backends[0]]
camera = ['--camera', '6,5,9:0,1,0:50:0.1:100']
few = ['--cascades', '3,1', '--resolutions', '128,64']

# A configuration that is not in the sweep is added; it is what the rest is compared with. No time left: one round all the same.
json.dump({'resolution': 256}, open(at('base.json'), 'w'))
text = run('--quick', '--minutes', '1e-9', *small, *camera, *few, '--case', 'bare_plane', '--config', at('base.json'), '--out', at('first'),
           '--json', at('first.json'))
assert '--config' in text and 'report.html' in text, text
first = load('first')
assert json.load(open(at('first.json')))['scenes'] == first['scenes']
shapes = [(c, r) for c in (1, 3) for r in (64, 128)]
check_scene(first['scenes'][0], shapes + [(4, 256)], 1)
assert shape(first['scenes'][0]['configurations'][first['scenes'][0]['base']]) == (4, 256, 'pcf_3x3', 'receiver_plane')
assert [b['name'] for b in first['backends']] == backends and all(b['driver'] for b in first['backends'])
assert first['machine']['cores'] >= 1 and first['quick'] and '--quick' in first['command'] and first['base_name'] == '--config'
assert not first['scenes'][0]['truth']['cached'] and first['left_out'] == []
(plane,) = first['hard']
assert plane['case'] == 'bare_plane' and plane['about'] and plane['seconds'] > 0 and len(plane['figures']) >= 3, plane
assert all(f['holds'] == (f['value'] <= f['bound']) and f['holds'] and f['unit'] for f in plane['figures']), plane
# A map may have no error at all here, and be faster, so it is rays' own error that is looked at.
drawn = first['scenes'][0]['configurations']
error_of = lambda p: p['backends'][backends[0]]['error']
least = min(error_of(p) for p in drawn if p['filter'] == 'exact')
assert error_of(drawn[first['scenes'][0]['verdicts'][backends[0]]['least_error']]) == least, 'rays are nearest the truth'
by_maps = [p for p in first['scenes'][0]['configurations'] if not p['filter'].startswith('exact')]
best = min(by_maps, key=error_of)
assert best['resolution'] == 256, 'four times the texels are nearer the truth'

# The same truth again, for another base; one in the sweep.
json.dump({'cascade_count': 3, 'resolution': 64, 'filter': 'pcf_2x2', 'split_lambda': 0.5}, open(at('own.json'), 'w'))
run('--quick', *small, *camera, '--cascades', '3', '--resolutions', '64', '--config', at('own.json'), '--out', at('own'))
own = load('own')
assert own['hard'] == []
check_scene(own['scenes'][0], [(3, 64)], 5)
assert own['scenes'][0]['truth']['cached'] and own['base_name'] == '--config' and own['scenes'][0]['base_config']['split_lambda'] == 0.5
assert shape(own['scenes'][0]['configurations'][own['scenes'][0]['base']]) == (3, 64, 'pcf_2x2', 'receiver_plane')

# Soft suns, two scenes: every filter, and the presets that are named. Scenes under one sun are judged together.
other = write_gltf(at('other.gltf'), ground + box((-3, 0, -3), (-2, 6, 4)))
json.dump({'cascade_count': 3, 'resolution': 256, 'filter': 'pcf_2x2'}, open(at('soft.json'), 'w'))
run(*small, '--scene', other, '--shadow-distance', '200', '--suns', '0,3', '--sun-samples', '16', '--cascades', '1', '--resolutions',
    '128', '--config', at('soft.json'), '--presets', 'low,godot', '--minutes', '1e-9', '--out', at('soft'))
soft = load('soft')
assert [(s['scene'], s['light']['disc_deg']) for s in soft['scenes']] == [(scene, 0), (scene, 3), (other, 0), (other, 3)]
for one in soft['scenes'][::2]:
    check_scene(one, [(1, 128), (3, 256)], 1)
for one in soft['scenes'][1::2]:
    check_points(one, 1)
    points, names = one['configurations'], [p['name'] for p in one['configurations']]
    assert one['error'] == 'rmse' and one['truth']['rays'] == 16 and 0 < one['truth']['noise'] < 0.05
    assert names[0] == '--config' and len(set(names)) == len(names) and [p['name'] for p in points if p['preset']] == ['low', 'godot']
    assert {p['filter'] for p in points} == {*FILTERS, 'vssm'}, {p['filter'] for p in points}
    assert all(shape(p)[:2] == (3, 256) for p in points if not p['preset'])
assert [(v['disc_deg'], v['scenes']) for v in soft['all']] == [(0, [0, 2]), (3, [1, 3])]
assert all(v['front'] and v['knee'] in v['front'] for v in soft['all'])


# Bad input gets a clear word, and no page.
def refused(word, *arguments):
    text = run('--out', at('refused'), *arguments, code=2)
    assert word in text, (word, text)
    assert not os.path.exists(at('refused', 'report.html')), arguments


for value in ('0', '9', '2,2', '1.5', 'x', '1,', ''):
    refused('--cascades', *small, '--cascades', value)
refused('--resolutions', *small, '--resolutions', '8')
refused('--resolutions', *small, '--resolutions', '64;128')
refused('--minutes', *small, '--minutes', '0')
refused('--camera', *camera)
refused('no case', *small, *few, '--case', 'bare_plane,nowhere')
refused('--dump', *small, '--dump', at('dump'))
refused('no scene', '--scene', 'nowhere')
refused('cannot open', '--scene', at('none.gltf'))
refused('inside a wall', *small, *few, '--camera', '0,1,0:1,1.2,0.1:50:0.1:100')
refused('turned away', '--scene', scene, '--size', '64x64', '--shadow-distance', '40', '--light', '0,1,0', *few, *camera)
refused('not a folder', *small, *camera, '--out', at('first.json'))
print('ok')

"""csm-host measure, end to end: python3 measure_test.py CSM_HOST BACKEND"""
import json, math, os, subprocess, sys, tempfile

from tiny_gltf import box, quad, write_gltf

host, backend = sys.argv[1:3]
folder = tempfile.TemporaryDirectory()
at = lambda name: os.path.join(folder.name, name)


def run(*arguments, code=0):
    command = [host, 'measure', '--backend', backend, '--out', at('out'), '--cache', at('cache'), '--json', at('m.json'),
               *arguments]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == code, (command, done.returncode, done.stderr)
    figures = done.stdout.lower().replace(folder.name.lower(), '')  # whose random name may hold anything
    assert 'nan' not in figures and 'inf ' not in figures, done.stdout
    return done.stderr if code else json.load(open(at('m.json')))


ground = quad((-20, 0, -20), (-20, 0, 20), (20, 0, 20), (20, 0, -20))
scene = write_gltf(at('box.gltf'), ground + box((-1, 0, -1), (1, 2, 1)))
common = ['--scene', scene, '--light', '0.5,-0.8,0.3', '--shadow-distance', '40', '--size', '320x180']
camera = ['--camera', '6,5,9:0,1,0:50:0.1:100']

# A box on the ground: most is right, and every figure is there.
first = run(*common, *camera, '--dump', at('dump'))
metrics = first['backends'][0]['metrics']
assert metrics['pixels'] > 20000 and 0.01 < 1 - metrics['lit'] < 0.5, metrics
assert metrics['false_lit'] + metrics['false_shadow'] < 0.01 and metrics['edge'] < 1.0, metrics
assert metrics['edge_true_px'] > 50 and metrics['rmse'] < 0.1
for key in ('acne', 'leak', 'mean', 'grazing_false_lit', 'grazing_false_shadow'):
    assert math.isfinite(metrics[key]), key
assert not first['truth']['cached']
dumped = json.load(open(os.path.join(at('dump'), backend, 'frame.json')))
assert dumped['metrics'] == metrics
for name in ('truth', backend + '-drawn', backend + '-errors'):
    assert os.path.getsize(os.path.join(at('out'), name + '.png')) > 500

# The same again is found; another configuration is measured against the same truth.
json.dump({'bias_constant_texels': 0, 'bias_slope_texels': 0, 'bias_normal_texels': 0}, open(at('bare.json'), 'w'))
bare = run(*common, *camera, '--config', at('bare.json'))
assert bare['truth']['cached']
assert bare['backends'][0]['metrics']['acne'] > 0.05 > 100 * metrics['acne'], 'without a bias there is acne'

# A soft sun converges.
soft = run('--scene', scene, '--light', '0.5,-0.8,0.3:4', '--shadow-distance', '40', '--size', '160x90', *camera)
assert soft['truth']['rays'] == 256 and 0 < soft['truth']['convergence']['rms_half'] < 0.02

# A camera's and a light's path: what stands still does not flicker.
json.dump([camera[1]] * 2, open(at('still.json'), 'w'))
still = run(*common, '--camera-path', at('still.json'))['backends'][0]['metrics']
assert still['flicker'] == 0 and still['crossing'] == 0 and still['flicker_points'] > 20000
with open(at('path.json'), 'w') as file:
    json.dump(['%g,5,9:%g,1,0:50:0.1:100' % (6 + 0.5 * i, 0.5 * i) for i in range(3)], file)
moving = run(*common, '--camera-path', at('path.json'))
assert len(moving['backends'][0]['frames']) == 3
assert 0 <= moving['backends'][0]['metrics']['flicker'] < 0.05
json.dump([{'direction': [0.5, -0.8, 0.3]}, {'direction': [0.6, -0.8, 0.3], 'disc_deg': 0}], open(at('lights.json'), 'w'))
lights = run(*common, *camera, '--light-path', at('lights.json'))['backends'][0]['metrics']
assert 0 <= lights['flicker'] < 0.1 and lights['flicker_points'] > 10000

# Two places 10,000 km apart in one mesh are more than shaders' floats tell: what is drawn lies elsewhere, and there are no
# figures that leave it out, of one frame or along a path.
apart = write_gltf(at('apart.gltf'), ground + [(x - 1e7, y, z) for x, y, z in ground])
moved = json.load(open(apart))
moved['nodes'] = [{'mesh': 0, 'translation': [1e7, 0, 0]}]
json.dump(moved, open(apart, 'w'))
lost = ['--scene', apart, *common[2:], *camera]
assert 'depth_pixels' in run(*lost, code=1)
assert 'depth_pixels' in run(*lost, '--camera-path', at('still.json'), code=1)
assert 'depth_pixels' in run(*lost, '--presets', 'low', code=1)


# Bad input gets a clear word.
def refused(word, *arguments):
    text = run(*arguments, code=2)
    assert word in text, (word, text)


def written(name, text):
    with open(at(name), 'w') as file:
        file.write(text)
    return at(name)


good = '"6,5,9:0,1,0:50:0.1:100"'
refused('line 7', *common, '--camera-path', written('a.json', '[\n' + (good + ',\n') * 5 + '"6,5,x:0,1,0:50"]'))
refused('line 7', *common, '--camera-path', written('b.json', '[\n' + (good + ',\n') * 5 + 'oops]'))
refused('line 7', *common, '--light-path', written('c.json', '[{"disc_deg": 1,\n\n\n\n\n\n"direction": [0, 0, 0]}]'))
refused('line 7', *common, '--light-path', written('d.json', '[\n\n\n\n\n\n{"direction": [0, 1]}]'))
refused('at least one', *common, '--camera-path', written('e.json', '{}'))
refused('cannot open', *common, '--camera-path', at('none.json'))
refused('2 lights', *common, '--light-path', at('lights.json'), '--camera-path', at('path.json'))
refused('no surface', *common, '--camera', '6,5,9:6,50,9.1:50:0.1:100')
refused('shadow distance', '--scene', scene, '--light', '0.5,-0.8,0.3', '--shadow-distance', '2', '--size', '64x64', *camera)
refused('turned away', '--scene', write_gltf(at('ground.gltf'), ground), '--light', '0,1,0', '--size', '64x64', '--shadow-distance',
        '40', *camera)
refused('inside a wall', *common, '--camera', '0,1,0:1,1.2,0.1:50:0.1:100')
refused('--sun-samples', *common, '--sun-samples', '2')
refused('not a folder', '--scene', scene, '--cache', at('m.json'))
empty = json.load(open(scene))
empty['nodes'] = [{}]
json.dump(empty, open(at('empty.gltf'), 'w'))
refused('no triangles', '--scene', at('empty.gltf'))

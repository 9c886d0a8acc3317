"""Batch files: what they expand to, and what they say about mistakes."""

import time

import pytest

from surftex.errors import RecipeError
from surftex.recipe.batch import load_batch
from surftex.recipe.batch_file import BatchFile, JobEntry
from surftex.recipe.model import BakeSettings, MeshSettings

MESH = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"


JOB = '[[job]]\nmesh = "bag.obj"\nmaterial = "calf"\n'


@pytest.fixture
def studio(tmp_path):
    for name in ("shoes/left.obj", "shoes/right.obj", "bag.obj"):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(MESH)
    (tmp_path / "my").mkdir()
    (tmp_path / "my" / "bird.toml").write_text('[[layer]]\npreset = "ostrich"\ncell_size = "4 mm"\n')
    return tmp_path


def batch(folder, text, **options):
    (folder / "jobs.toml").write_text(text)
    return load_batch(folder / "jobs.toml", **options)


def test_meshes_times_materials_times_seeds_then_single_jobs(studio):
    found = batch(
        studio,
        """
        surftex = 1
        meshes = ["shoes/*.obj", "bag.obj"]
        materials = ["calf", "my/bird.toml"]
        seeds = [1, 2]
        resolution = 512
        units = "m"
        out = "baked"
        [[job]]
        mesh = "bag.obj"
        material = "goat"
        resolution = 64
        maps = ["height"]
        set = ["cell_size=2 mm"]
        """,
    )
    assert found.out == studio / "baked"
    names = [job.name for job in found.jobs]
    assert names[:4] == ["left-calf-1", "left-calf-2", "left-bird-1", "left-bird-2"]
    assert len(names) == 13
    assert names[-1] == "bag-goat"
    first, last = found.jobs[0].recipe, found.jobs[-1].recipe
    assert (first.seed, first.bake.resolution, first.mesh.units) == (1, 512, "m")
    assert first.mesh.path == str(studio / "shoes" / "left.obj")
    assert (last.bake.resolution, last.bake.maps, last.mesh.units) == (64, ("height",), "m")
    assert last.layer[0].material.cell_size == 2.0
    assert found.jobs[2].recipe.layer[0].material.cell_size == 4.0


def test_meshes_of_one_name_are_told_apart_by_their_folders(studio):
    (studio / "boots").mkdir()
    (studio / "boots" / "left.obj").write_text(MESH)
    found = batch(studio, 'meshes = ["*/*.obj"]\nmaterials = ["calf"]')
    assert [job.name for job in found.jobs] == ["boots-left.obj-calf", "shoes-left.obj-calf", "right-calf"]


def test_a_recipe_names_its_own_mesh(studio):
    (studio / "seat.toml").write_text('[mesh]\npath = "bag.obj"\nunits = "cm"\n[[layer]]\npreset = "pig"\n')
    found = batch(studio, '[[job]]\nrecipe = "seat.toml"\nseed = 4')
    assert [job.name for job in found.jobs] == ["seat-4"]
    assert found.jobs[0].recipe.mesh.units == "cm"
    assert found.jobs[0].recipe.seed == 4


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ('meshs = ["bag.obj"]', "jobs.toml:1: meshs: unknown key; did you mean meshes?"),
        ('meshes = ["bag.obj"]', "materials: this key is needed"),
        ("", "no jobs"),
        ('meshes = ["*.stl"]\nmaterials = ["calf"]', "jobs.toml:1: meshes: nothing matches '*.stl'"),
        ('meshes = ["bag.obj"]\nmaterials = ["claf"]', "jobs.toml:2: there is no preset 'claf'; did you mean calf?"),
        ('meshes = ["../bag.obj"]\nmaterials = ["calf"]', "jobs.toml:1: meshes: '../bag.obj' leaves the batch's folder"),
        ('meshes = ["../*.obj"]\nmaterials = ["calf"]', "leaves the batch's folder"),
        ('meshes = ["bag.obj"]\nmaterials = ["../bird.toml"]', "jobs.toml:2: materials: '../bird.toml' leaves"),
        ('meshes = ["/etc/*.obj"]\nmaterials = ["calf"]', "leaves the batch's folder"),
        ('meshes = ["bag.obj"]\nmaterials = ["calf"]\n' + JOB, "jobs.toml:3: job: two jobs write to 'bag-calf'; give it"),
        ('out = ".."\nmeshes = ["bag.obj"]\nmaterials = ["calf"]', "jobs.toml:1: out: '..' leaves the batch's folder"),
        ('[[job]]\nmesh = "bag.obj"', "jobs.toml:1: job: give either material or recipe"),
        ('[[job]]\nmaterial = "calf"', "a material needs a mesh"),
        ('[[job]]\nmesh = "bag.obj"\nmaterial = "calf"\nout = "a/b"', "jobs.toml:4: job.out: 'a/b' is no name"),
        (JOB + 'out = "a\\u0000"', "jobs.toml:4: job.out: 'a\\x00' cannot be a folder"),
        (JOB + 'out = "a\\u001b[31m"', "jobs.toml:4: job.out: 'a\\x1b[31m' cannot be a folder"),
        (JOB + f'out = "{"a" * 300}"', "... is too long for a folder; at most 200 bytes"),
        (JOB + f'out = "{"ä" * 101}"', "... is too long for a folder; at most 200 bytes"),
        (JOB + 'out = "Batch-Report.json"', "jobs.toml:4: job.out: 'Batch-Report.json' is the report of the batch"),
        (JOB + 'out = "A"\n' + JOB + 'out = "a"', "two jobs write to 'A' and 'a', one folder on many disks"),
        (JOB + 'out = "\\u00e4"\n' + JOB + 'out = "a\\u0308"', "one folder on many disks"),
        (JOB + "resolution = 5", "jobs.toml:4: job[1].resolution: 5: should be greater than or equal to 16"),
        (JOB + JOB + 'out = "b"\nunits = "km"', "jobs.toml:8: job[2].units: 'km': should be 'mm', 'cm', 'm' or 'in'"),
        ('meshes = ["bag.obj"]\nmaterials = ["calf"]\nresolution = "big"', "jobs.toml:3: resolution: 'big': should be a valid"),
        ('size = "3 parsecs"\n' + JOB, "jobs.toml:1: size: "),
        ('maps = ["hieght"]\n' + JOB, "jobs.toml:1: maps: unknown map 'hieght'; did you mean height?"),
        ("texels_per_mm = 3\n" + JOB, "jobs.toml:1: texels_per_mm spreads an unwrap over tiles"),
        (JOB + "texels_per_mm = 3", "jobs.toml:4: texels_per_mm spreads an unwrap over tiles"),
        (JOB + 'set = ["cell_size=4 mm", "cell_sze=3"]', "jobs.toml:4: set cell_sze=3: layer.cell_sze: unknown key"),
        ('set = ["cell_size"]\n' + JOB, "jobs.toml:1: set 'cell_size' is no change"),
        ('seeds = ["one"]', "jobs.toml:1: seeds[1]: 'one': should be a valid integer"),
        ('meshes = ["bag.obj"]\nmaterials = ["your/*.toml"]', "jobs.toml:2: materials: nothing matches 'your/*.toml'"),
        (f'out = "{"o" * 300}"\n' + JOB, f"jobs.toml:1: out: '{'o' * 60}'... is too long for a path"),
        ("meshes = [", "jobs.toml:1: "),
    ],
)  # fmt: skip
def test_mistakes_are_told_where_they_stand(studio, text, said):
    with pytest.raises(RecipeError) as caught:
        batch(studio, text)
    assert said in str(caught.value)
    assert "\n" not in str(caught.value)
    assert str(caught.value).count("jobs.toml:") <= 1


def test_a_glob_takes_no_mesh_that_the_batch_has_baked(studio):
    text = 'meshes = ["**/*.obj"]\nmaterials = ["calf"]\n'
    names = [job.name for job in batch(studio, text).jobs]
    (studio / "out" / "bag-calf").mkdir(parents=True)
    (studio / "out" / "bag-calf" / "bag.obj").write_text(MESH)
    assert [job.name for job in batch(studio, text).jobs] == names
    assert [job.name for job in batch(studio, text + 'out = "."').jobs] != names


def test_recipes_are_found_by_globs_as_meshes_are(studio):
    (studio / "my" / "ant.toml").write_text('[[layer]]\npreset = "goat"\n')
    (studio / "out" / "old").mkdir(parents=True)
    (studio / "out" / "old" / "kept.toml").write_text('[[layer]]\npreset = "goat"\n')
    (studio / "zebra.toml").write_text('[[layer]]\npreset = "goat"\n')
    text = 'meshes = ["bag.obj"]\nmaterials = ["pig", "my/bird.toml", "**/*.toml", "pig"]\nseeds = [2, 1, 2]'
    names = [
        job.name for job in batch(studio, text).jobs
    ]  # neither this batch, nor what it wrote, nothing twice
    each = ("pig", "bird", "ant", "zebra")
    assert names == [f"bag-{material}-{seed}" for material in each for seed in (2, 1)]


def test_recipes_of_one_name_are_told_apart_by_their_folders(studio):
    for folder in ("own", "Her", "calf"):
        (studio / folder).mkdir()
        name = "calf" if folder == "calf" else "bird" if folder == "own" else "BIRD"
        (studio / folder / f"{name}.toml").write_text('[[layer]]\npreset = "goat"\n')
    text = """
        meshes = ["bag.obj"]
        materials = ["my/bird.toml", "Her/*.toml", "calf", "calf/calf.toml"]
        [[job]]
        mesh = "bag.obj"
        recipe = "own/bird.toml"
        [[job]]
        mesh = "shoes/left.obj"
        recipe = "my/bird.toml"
        """
    found = batch(studio, text).jobs
    names = ["bag-my-bird", "bag-Her-BIRD", "bag-calf", "bag-calf-calf", "bag-own-bird", "left-my-bird"]
    assert [job.name for job in found] == names
    assert found[0].recipe.layer[0].material.cell_size == 4.0
    assert batch(studio, text.partition("[[job]]")[0]).jobs[0].name == names[0]


def test_single_jobs_rename_nothing_of_the_product(studio):
    (studio / "bag.ply").write_text("ply")
    (studio / "own").mkdir()
    (studio / "own" / "bird.toml").write_text('[[layer]]\npreset = "goat"\n')
    text = """
        meshes = ["bag.obj"]
        materials = ["my/bird.toml"]
        [[job]]
        mesh = "bag.ply"
        recipe = "my/bird.toml"
        [[job]]
        mesh = "bag.obj"
        recipe = "own/bird.toml"
        """
    names = [job.name for job in batch(studio, text).jobs]
    assert names == ["bag-bird", "bag.ply-bird", "bag-own-bird"]


def test_a_mesh_whose_name_looks_like_a_glob_is_found(studio):
    for name in ("a[1].obj", "a1.obj"):
        (studio / name).write_text(MESH)
    names = [
        [job.name for job in batch(studio, f'meshes = ["{each}"]\nmaterials = ["calf"]').jobs]
        for each in ("a[1].obj", "a[12].obj", "a*.obj")
    ]
    assert names == [["a[1]-calf"], ["a1-calf"], ["a1-calf", "a[1]-calf"]]


def test_every_option_of_a_bake_may_stand_in_a_batch():
    options = {*BakeSettings.model_fields, *MeshSettings.model_fields} - {"path"}
    assert options <= {*BatchFile.model_fields}
    assert options <= {*JobEntry.model_fields}


def test_a_batch_of_many_seeds_is_read_in_a_moment(studio):
    seeds = ", ".join(map(str, range(30_000)))
    began = time.process_time()
    found = batch(studio, f'meshes = ["bag.obj"]\nmaterials = ["calf"]\nseeds = [{seeds}]')
    assert time.process_time() - began < 10
    assert [job.recipe.seed for job in found.jobs] == list(range(30_000))
    assert found.jobs[-1].recipe.places is found.jobs[0].recipe.places


def test_a_mesh_whose_name_is_too_long_for_a_folder_is_told(studio):
    (studio / f"{'m' * 199}.obj").write_text(MESH)
    with pytest.raises(RecipeError, match=r"jobs.toml:1: meshes: 'm+\.\.\. is too long for a folder"):
        batch(studio, 'meshes = ["m*.obj"]\nmaterials = ["calf"]')


def test_files_outside_may_be_allowed(studio):
    inner = studio / "shoes"
    text = 'meshes = ["../bag.obj"]\nmaterials = ["calf"]'
    assert batch(inner, text, allow_outside=True).jobs[0].recipe.mesh.path == str(studio / "bag.obj")


def test_a_link_that_leads_outside_is_not_followed(studio):
    (studio / "shoes" / "link.obj").symlink_to(studio / "bag.obj")
    with pytest.raises(RecipeError, match="leaves the batch's folder"):
        batch(studio / "shoes", 'meshes = ["*.obj"]\nmaterials = ["calf"]')

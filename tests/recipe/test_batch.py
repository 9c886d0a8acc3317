"""Batch files: what they expand to, and what they say about mistakes."""

import time

import pytest

from surftex.errors import RecipeError
from surftex.recipe.batch import load_batch

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
        ('meshes = ["bag.obj"]\nmaterials = ["calf", "calf"]', "two jobs write to 'bag-calf'"),
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
        ('[[job]]\nmesh = "bag.obj"\nmaterial = "calf"\nresolution = 5', "resolution"),
        ('seeds = ["one"]', "jobs.toml:1: seeds.1: input should be a valid integer"),
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

from tests.materials.baselines import main

main()

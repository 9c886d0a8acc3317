// Prints Khronos' glTF validator's issues about a file and those beside it: node validate.js VALIDATOR_PACKAGE FILE
const [, , validator, file] = process.argv;
const { dirname, join } = require("path");
const read = (path) => new Uint8Array(require("fs").readFileSync(path));
require(validator)
  .validateBytes(read(file), {
    externalResourceFunction: async (uri) => read(join(dirname(file), decodeURIComponent(uri))),
  })
  .then((report) => console.log(JSON.stringify(report)));

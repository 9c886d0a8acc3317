// Prints Khronos' glTF validator's issues about a file: node validate.js VALIDATOR_PACKAGE FILE
const [, , validator, file] = process.argv;
require(validator)
  .validateBytes(new Uint8Array(require("fs").readFileSync(file)))
  .then((report) => console.log(JSON.stringify(report)));

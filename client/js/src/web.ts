// SPDX-License-Identifier: Apache-2.0
// segserve for browsers. In Node, `import .. from 'segserve/web'` has the same.
export * from './common.js';
export {Client, type ClientOptions} from './web/client.js';
